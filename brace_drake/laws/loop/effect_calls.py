"""Calls of the effects' laws at the plug points of a brace.

An effect's law is that of one machine. Where a loop carries several copies,
see `laws.lanes`, it is called for each of them in turn: what it takes is copied
out, and what it changes is copied back. `effects` are as `laws.hooks` has them,
`e` is the effect, `i` the stage; the rest is what the plug point hands over.
"""

from typing import NamedTuple

import numpy as np
from numba import boolean, float64, types
from numba.extending import overload

from brace_drake.laws.compiled import LAW, compiled_law
from brace_drake.laws.hooks import (
    COMPRESSION,
    CONTACT,
    DRIVE,
    MAX_EFFECTS,
    RING,
    SENSING,
    STAGE_POINTS,
    TORSO,
    stack_type,
)
from brace_drake.laws.lanes.arrays import floats_of
from brace_drake.laws.lanes.kinds import COUNT, LANES


class EffectsOfCopies(NamedTuple):
    """Effects at the plug points of several copies of a brace.

    Attributes:
        laws, active: As of `hooks.Effects`, the same for all copies.
        parameters: Of each effect, of each copy a row for each stage
            (copies, n, m).
        memory: Of each plug point, states of each effect (copies, n, s).
        work: Places for what a law takes and changes (5, 12).
    """

    laws: tuple
    parameters: tuple
    memory: tuple
    active: np.ndarray
    work: np.ndarray


_cubes = types.UniTuple(float64[:, :, ::1], MAX_EFFECTS)
EFFECTS_OF_COPIES = types.NamedTuple(
    (
        types.Tuple(tuple(stack_type(point) for point in STAGE_POINTS)),
        _cubes,
        types.UniTuple(_cubes, len(STAGE_POINTS)),
        boolean[:, ::1],
        float64[:, ::1],
    ),
    EffectsOfCopies,
)


@compiled_law
def _take(lanes, copy, row):
    """Writes one copy's values (n,) of lanes (n,) into a row."""
    floats = floats_of(lanes)
    for k in range(lanes.shape[0]):
        row[k] = floats[k, copy]


@compiled_law
def _put(row, copy, lanes):
    """Writes one copy's values back."""
    floats = floats_of(lanes)
    for k in range(lanes.shape[0]):
        floats[k, copy] = row[k]


_OPTIONS = {k: v for k, v in LAW.items() if k != "cache"}


def _of_copies(array) -> bool:
    return array.dtype == LANES


def call_drive(effects, e, i, t, dt, u, l, l_dot, law, f):  # noqa: E741
    """At a stage's drive."""
    effects.laws[DRIVE][e](
        t, dt, u, l, l_dot, law, f, effects.parameters[e][i],
        effects.memory[DRIVE][e][i],
    )  # fmt: skip


@overload(call_drive, jit_options=_OPTIONS)
def _drive(effects, e, i, t, dt, u, l, l_dot, law, f):  # noqa: E741
    if not _of_copies(f):
        return call_drive

    def drive_copies(effects, e, i, t, dt, u, l, l_dot, law, f):  # noqa: E741
        n, work = f.shape[0], effects.work
        for copy in range(COUNT):
            _take(u, copy, work[0])
            _take(l, copy, work[1])
            _take(l_dot, copy, work[2])
            _take(law, copy, work[3])
            _take(f, copy, work[4])
            effects.laws[DRIVE][e](
                t, dt, work[0, 0:n], work[1, 0:n], work[2, 0:n], work[3, 0:n],
                work[4, 0:n], effects.parameters[e][copy, i],
                effects.memory[DRIVE][e][copy, i],
            )  # fmt: skip
            _put(work[4], copy, f)

    return drive_copies


def call_compression(effects, e, i, t, dt, pad, d):
    """At the compression of one of a ring's pads."""
    effects.laws[COMPRESSION][e](
        t, dt, pad, d, effects.parameters[e][i],
        effects.memory[COMPRESSION][e][i],
    )  # fmt: skip


@overload(call_compression, jit_options=_OPTIONS)
def _compression(effects, e, i, t, dt, pad, d):
    if not _of_copies(d):
        return call_compression

    def compress_copies(effects, e, i, t, dt, pad, d):
        work = effects.work
        for copy in range(COUNT):
            _take(d, copy, work[0])
            effects.laws[COMPRESSION][e](
                t, dt, pad, work[0, 0:2], effects.parameters[e][copy, i],
                effects.memory[COMPRESSION][e][copy, i],
            )  # fmt: skip
            _put(work[0], copy, d)

    return compress_copies


def call_contact(effects, e, i, t, dt, pad, d, law, N):
    """At the normal force of one of a ring's pads."""
    effects.laws[CONTACT][e](
        t, dt, pad, d, law, N, effects.parameters[e][i],
        effects.memory[CONTACT][e][i],
    )  # fmt: skip


@overload(call_contact, jit_options=_OPTIONS)
def _contact(effects, e, i, t, dt, pad, d, law, N):
    if not _of_copies(N):
        return call_contact

    def press_copies(effects, e, i, t, dt, pad, d, law, N):
        work = effects.work
        for copy in range(COUNT):
            _take(d, copy, work[0])
            _take(law, copy, work[1])
            _take(N, copy, work[2])
            effects.laws[CONTACT][e](
                t, dt, pad, work[0, 0:2], work[1, 0:6], work[2, 0:1],
                effects.parameters[e][copy, i],
                effects.memory[CONTACT][e][copy, i],
            )  # fmt: skip
            _put(work[2], copy, N)

    return press_copies


def call_ring(effects, e, i, t, dt, p_R, r_R, V, F):
    """At a ring."""
    effects.laws[RING][e](
        t, dt, p_R, r_R, V, F, effects.parameters[e][i],
        effects.memory[RING][e][i],
    )  # fmt: skip


@overload(call_ring, jit_options=_OPTIONS)
def _ring(effects, e, i, t, dt, p_R, r_R, V, F):
    if not _of_copies(F):
        return call_ring

    def push_copies(effects, e, i, t, dt, p_R, r_R, V, F):
        work = effects.work
        for copy in range(COUNT):
            _take(p_R, copy, work[0])
            _take(r_R, copy, work[1])
            _take(V, copy, work[2])
            _take(F, copy, work[3])
            effects.laws[RING][e](
                t, dt, work[0, 0:3], work[1, 0:3], work[2, 0:6], work[3, 0:6],
                effects.parameters[e][copy, i],
                effects.memory[RING][e][copy, i],
            )  # fmt: skip
            _put(work[3], copy, F)

    return push_copies


def call_torso(effects, e, t, dt, p_T, r_T, V, law, F):
    """At the torso."""
    effects.laws[TORSO][e](
        t, dt, p_T, r_T, V, law, F, effects.parameters[e][0],
        effects.memory[TORSO][e][0],
    )  # fmt: skip


@overload(call_torso, jit_options=_OPTIONS)
def _torso(effects, e, t, dt, p_T, r_T, V, law, F):
    if not _of_copies(F):
        return call_torso

    def hold_copies(effects, e, t, dt, p_T, r_T, V, law, F):
        work = effects.work
        for copy in range(COUNT):
            _take(p_T, copy, work[0])
            _take(r_T, copy, work[1])
            _take(V, copy, work[2])
            _take(law, copy, work[3])
            _take(F, copy, work[4])
            effects.laws[TORSO][e](
                t, dt, work[0, 0:3], work[1, 0:3], work[2, 0:6], work[3],
                work[4, 0:6], effects.parameters[e][copy, 0],
                effects.memory[TORSO][e][copy, 0],
            )  # fmt: skip
            _put(work[4], copy, F)

    return hold_copies


def call_sensing(effects, e, i, t, h, u, l, F):  # noqa: E741
    """At a stage's readings."""
    effects.laws[SENSING][e](
        t, h, u, l, F, effects.parameters[e][i], effects.memory[SENSING][e][i]
    )


@overload(call_sensing, jit_options=_OPTIONS)
def _sensing(effects, e, i, t, h, u, l, F):  # noqa: E741
    if not _of_copies(F):
        return call_sensing

    def read_copies(effects, e, i, t, h, u, l, F):  # noqa: E741
        work = effects.work
        for copy in range(COUNT):
            _take(u, copy, work[0])
            _take(l, copy, work[1])
            _take(F, copy, work[2])
            effects.laws[SENSING][e](
                t, h, work[0, 0:6], work[1, 0:6], work[2, 0:3],
                effects.parameters[e][copy, i],
                effects.memory[SENSING][e][copy, i],
            )  # fmt: skip
            _put(work[1], copy, l)
            _put(work[2], copy, F)

    return read_copies

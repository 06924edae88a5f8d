"""A brace tick by tick, for whoever computes its commands elsewhere.

A tick in two halves: what the instruments read; then, when the commands have
come, the plant's steps until the next tick. With one stage it is the bench,
held bit by bit to `bench_rollout`, which has the controller inside; with
several it is held to the diagram. Effects act on every stage alike, each stage
with a memory of its own, and once on the torso.
"""

import math

import numpy as np
from numba import boolean, float64, int64, njit, types

from brace_drake.laws import stages
from brace_drake.laws.compiled import (
    MAKER,
    compiled_law,
    compiled_maker,
    copy_values,
)
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    PLUG_POINTS,
    matrix,
    stack_type,
    vector,
    vectors,
)
from brace_drake.laws.loop import blocks
from brace_drake.laws.rigid_body import step_free_body_at
from brace_drake.laws.rotation import quaternion_to_matrix

# Rest of the torso, viscous, posture, resolution.
_LAWS = types.UniTuple(vector, 4)
_ARGUMENTS = (
    float64,
    int64,
    boolean[::1],
    types.UniTuple(float64[:, :, ::1], 2),
    matrix,
    matrix,
    _LAWS,
    types.Tuple((matrix, vector)),
    *[stack_type(point) for point in PLUG_POINTS],
    vectors,
    *[vectors] * len(PLUG_POINTS),
    boolean[:, ::1],
    vector,
    vector,
    vector,
    vector,
)


@compiled_maker
def _own(memory, i, n):
    """The part of stage i of n of a memory that all stages share out."""
    size = memory.shape[0] // n
    return memory[i * size : (i + 1) * size]


@compiled_maker
def _press_pads(
    t, dt, i, n, bodies, R, R_WT, law, pair, pads, active, compression,
    contact, parameters, compression_memory, contact_memory, F, F_T, f_T,
):  # fmt: skip
    """Adds the forces of ring i's pads; `pair` (26,) is a place to work in."""
    at = 7 * (n + 1)
    copy_values(bodies[7 * i : 7 * i + 7], pair[0:7])
    copy_values(bodies[7 * n : 7 * n + 7], pair[7:14])
    copy_values(bodies[at + 6 * i : at + 6 * i + 6], pair[14:20])
    copy_values(bodies[at + 6 * n : at + 6 * n + 6], pair[20:26])
    blocks.add_hooked_pads(
        t, dt, pair, R, R_WT, law, pads, active, compression, contact,
        parameters,
        (_own(compression_memory[0], i, n), _own(compression_memory[1], i, n)),
        (_own(contact_memory[0], i, n), _own(contact_memory[1], i, n)),
        F, F_T, f_T,
    )  # fmt: skip


@compiled_maker
def _read(
    t, period, n, u, resolution, noise, active, sensing, parameters, memory,
    readings,
):  # fmt: skip
    """Turns ideal values into readings: effects, noise, rounding."""
    for e in range(MAX_EFFECTS):
        if not active[5, e]:
            continue
        for i in range(n):
            at = 6 * n + 3 * i
            sensing[e](
                t, period, u[6 * i : 6 * i + 6], readings[6 * i : 6 * i + 6],
                readings[at : at + 3], parameters[e], _own(memory[e], i, n),
            )  # fmt: skip
    blocks.read_instruments(resolution, noise, readings)


@compiled_maker
def _drive_legs(
    t, dt, n, u, lengths, rates, viscous, active, drive, parameters, memory, f
):
    """Writes the forces of all legs f (6 S,), N."""
    blocks.calc_leg_forces(u, viscous, rates, f)
    for e in range(MAX_EFFECTS):
        if not active[0, e]:
            continue
        for i in range(n):
            a, b = 6 * i, 6 * i + 6
            drive[e](
                t, dt, u[a:b], lengths[a:b], rates[a:b], viscous[a:b], f[a:b],
                parameters[e], _own(memory[e], i, n),
            )  # fmt: skip


@compiled_maker
def _add_ring_effects(
    t, dt, n, poses, V, rest, pose, active, ring, parameters, memory, F
):
    for i in range(n):
        blocks.calc_displacement(poses[i, 0:4], poses[i, 4:7], rest[i], pose)
        for e in range(MAX_EFFECTS):
            if not active[4, e]:
                continue
            ring[e](
                t, dt, pose[0:3], pose[3:6], V[i], F[i], parameters[e],
                _own(memory[e], i, n),
            )  # fmt: skip


@compiled_law
def _add_posture(
    t, dt, pair, rest, posture, pose, active, torso, parameters, memory, F_T
):
    blocks.add_posture(pair, rest, posture, pose, F_T)
    for e in range(MAX_EFFECTS):
        if not active[3, e]:
            continue
        torso[e](
            t, dt, pose[0:3], pose[3:6], pair[20:26], posture, F_T,
            parameters[e], memory[e],
        )  # fmt: skip


@njit(_ARGUMENTS, **MAKER)
def run_ticks(
    dt,
    steps,
    with_torso,
    anchors,
    rest,
    contact_laws,
    laws,
    bodies_mass,
    drive,
    compression,
    contact,
    torso,
    ring,
    sensing,
    parameters,
    drive_memory,
    compression_memory,
    contact_memory,
    torso_memory,
    ring_memory,
    sensing_memory,
    active,
    bodies,
    noise,
    readings,
    u,
):
    """A generator: writes a tick's readings, yields, advances by a tick.

    What the caller writes into `with_torso`, `noise`, `u` and the laws between
    two ticks counts from then on. (Handing over functions to compiled code at
    each tick would cost a thousand times what a tick does.)

    Args:
        dt, steps: Plant step, s; steps in a tick.
        with_torso: Whether the torso is there (1,).
        anchors: Lower and upper anchors (S, 6, 3), m, see `laws.stages`.
        rest: Positions of the rings at rest (S, 3), m.
        contact_laws: Of each ring (S, 6), see `blocks.calc_pad`; stiffness and
            damping 0: no pads.
        laws: Position of the torso at rest (3), viscous (6 S), posture (12),
            resolution (2).
        bodies_mass: Of the rings (S, 5) and the torso (5,): mass, moments (3),
            weight.
        drive ... active: As in `rollout_bench`; memories S times as long, but
            for the torso's.
        bodies: q, p of the rings and the torso, then [w; v] of each
            (13 S + 13,), updated.
        noise: Of lengths (6 S), m, forces (3 S), N, marker (3), m; NaN in the
            first place for exact readings (9 S + 3,).
        readings: Output (9 S + 3,), as `noise`.
        u: Leg commands (6 S,), N, read after each yield.

    Yields:
        The tick's number.
    """
    torso_rest, viscous, posture, resolution = laws
    lower, upper = anchors
    ring_mass, torso_mass = bodies_mass
    n = rest.shape[0]
    poses = bodies[0 : 7 * n + 7].reshape((n + 1, 7))
    V = bodies[7 * n + 7 : 13 * n + 13].reshape((n + 1, 6))
    R, R_WT = np.empty((n, 3, 3)), np.empty((3, 3))
    p_WB, J, J_L = np.empty((n, 6, 3)), np.empty((n, 6, 6)), np.empty((n, 6, 6))
    lengths, rates, f = np.empty(6 * n), np.empty(6 * n), np.empty(6 * n)
    F, F_T, f_T = np.zeros((n, 6)), np.zeros(6), np.zeros((n, 3))
    pair, pads, pose = np.zeros(26), np.empty((2, 17)), np.empty(6)
    no_noise = np.empty(0)
    tick, period = 0, dt * steps
    while True:
        for sub in range(steps):
            t = tick * period + sub * dt
            stages.calc_kinematics(
                poses[0:n], lower, upper, R, p_WB, lengths, J, J_L
            )
            stages.calc_rates(J, J_L, V[0:n], rates)
            quaternion_to_matrix(poses[n, 0:4], R_WT)
            # A torso that has gone leaves no force behind.
            F[:], F_T[:], f_T[:] = 0.0, 0.0, 0.0
            for i in range(n):
                law = contact_laws[i]
                if with_torso[0] and (law[0] != 0.0 or law[1] != 0.0):
                    _press_pads(
                        t, dt, i, n, bodies, R[i], R_WT, law, pair, pads,
                        active, compression, contact, parameters,
                        compression_memory, contact_memory, F[i], F_T, f_T[i],
                    )  # fmt: skip
            if sub == 0:
                copy_values(lengths, readings[0 : 6 * n])
                for i in range(n):
                    for c in range(3):
                        readings[6 * n + 3 * i + c] = f_T[i, c]
                for c in range(3):
                    readings[9 * n + c] = poses[n, 4 + c] - torso_rest[c]
                _read(
                    t, period, n, u, resolution,
                    no_noise if math.isnan(noise[0]) else noise,
                    active, sensing, parameters, sensing_memory, readings,
                )  # fmt: skip
                yield tick
            _drive_legs(
                t, dt, n, u, lengths, rates, viscous, active, drive,
                parameters, drive_memory, f,
            )  # fmt: skip
            stages.add_wrenches(J, J_L, f, F)
            _add_ring_effects(
                t, dt, n, poses, V, rest, pose, active, ring, parameters,
                ring_memory, F,
            )  # fmt: skip
            if with_torso[0]:
                copy_values(poses[n], pair[7:14])
                copy_values(V[n], pair[20:26])
                _add_posture(
                    t, dt, pair, torso_rest, posture, pose, active, torso,
                    parameters, torso_memory, F_T,
                )  # fmt: skip
                step_free_body_at(
                    R_WT, poses[n, 0:4], poses[n, 4:7], V[n], torso_mass, F_T,
                    dt,
                )  # fmt: skip
            for i in range(n):
                F[i, 5] -= ring_mass[i, 4]
                step_free_body_at(
                    R[i], poses[i, 0:4], poses[i, 4:7], V[i], ring_mass[i],
                    F[i], dt,
                )  # fmt: skip
        tick += 1

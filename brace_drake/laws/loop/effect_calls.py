"""Calls of the effects' laws at the plug points of a brace.

An effect's law is that of one machine. Where a loop carries several copies,
see `laws.lanes`, it is called once where it serves lanes and all copies have
it, otherwise for each of them in turn: what it takes is copied out, and what it
changes is copied back. `effects` are as `laws.hooks` has them,
`e` is the effect, `i` the stage; the rest is what the plug point hands over.
"""

from numba.extending import overload

from brace_drake.laws.compiled import LAW, compiled_law
from brace_drake.laws.hooks import (
    COMPRESSION,
    CONTACT,
    DRIVE,
    RING,
    SENSING,
    TORSO,
    caller_of,
)
from brace_drake.laws.lanes.arrays import floats_of, lanes_in
from brace_drake.laws.lanes.kinds import COUNT, LANES

_drive_law = caller_of("drive")
_compression_law = caller_of("compression")
_contact_law = caller_of("contact")
_torso_law = caller_of("torso")
_ring_law = caller_of("ring")
_sensing_law = caller_of("sensing")
_drive_laws = caller_of("drive", lanes=True)
_compression_laws = caller_of("compression", lanes=True)
_contact_laws = caller_of("contact", lanes=True)
_torso_laws = caller_of("torso", lanes=True)
_ring_laws = caller_of("ring", lanes=True)
_sensing_laws = caller_of("sensing", lanes=True)
_OPTIONS = {k: v for k, v in LAW.items() if k != "cache"}


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


@compiled_law
def _law_of(effects, point, e, copy, i):
    """Address, parameters and states of a law."""
    p, x = effects.places[0, e, copy, i], effects.places[1 + point, e, copy, i]
    return (
        effects.laws[point, e, copy],
        effects.parameters[p[0] : p[1]],
        effects.memory[x[0] : x[1]],
    )


@compiled_law
def _law_of_all(effects, point, e, i):
    """The same of a law that serves all copies at once."""
    address, p, x = _law_of(effects, point, e, 0, i)
    return address, lanes_in(p), lanes_in(x)


def call_drive(effects, e, i, t, dt, u, l, l_dot, law, f):  # noqa: E741
    """At a stage's drive."""
    address, p, x = _law_of(effects, DRIVE, e, 0, i)
    _drive_law(address, (t, dt, u, l, l_dot, law, f, p, x))


@overload(call_drive, jit_options=_OPTIONS)
def _drive(effects, e, i, t, dt, u, l, l_dot, law, f):  # noqa: E741
    if f.dtype != LANES:
        return call_drive

    def each(effects, e, i, t, dt, u, l, l_dot, law, f):  # noqa: E741
        if effects.together[e]:
            address, p, x = _law_of_all(effects, DRIVE, e, i)
            _drive_laws(address, (t, dt, u, l, l_dot, law, f, p, x))
            return
        work = effects.work
        for copy in range(COUNT):
            address, p, x = _law_of(effects, DRIVE, e, copy, i)
            if address == 0:
                continue
            _take(u, copy, work[0])
            _take(l, copy, work[1])
            _take(l_dot, copy, work[2])
            _take(law, copy, work[3])
            _take(f, copy, work[4])
            _drive_law(
                address,
                (
                    t,
                    dt,
                    work[0, 0:6],
                    work[1, 0:6],
                    work[2, 0:6],
                    work[3, 0:6],
                    work[4, 0:6],
                    p,
                    x,
                ),
            )
            _put(work[4], copy, f)

    return each


def call_compression(effects, e, i, t, dt, pad, d):
    """At the compression of one of a ring's pads."""
    address, p, x = _law_of(effects, COMPRESSION, e, 0, i)
    _compression_law(address, (t, dt, pad, d, p, x))


@overload(call_compression, jit_options=_OPTIONS)
def _compression(effects, e, i, t, dt, pad, d):
    if d.dtype != LANES:
        return call_compression

    def each(effects, e, i, t, dt, pad, d):
        if effects.together[e]:
            address, p, x = _law_of_all(effects, COMPRESSION, e, i)
            _compression_laws(address, (t, dt, pad, d, p, x))
            return
        work = effects.work
        for copy in range(COUNT):
            address, p, x = _law_of(effects, COMPRESSION, e, copy, i)
            if address == 0:
                continue
            _take(d, copy, work[0])
            _compression_law(address, (t, dt, pad, work[0, 0:2], p, x))
            _put(work[0], copy, d)

    return each


def call_contact(effects, e, i, t, dt, pad, d, law, N):
    """At the normal force of one of a ring's pads."""
    address, p, x = _law_of(effects, CONTACT, e, 0, i)
    _contact_law(address, (t, dt, pad, d, law, N, p, x))


@overload(call_contact, jit_options=_OPTIONS)
def _contact(effects, e, i, t, dt, pad, d, law, N):
    if N.dtype != LANES:
        return call_contact

    def each(effects, e, i, t, dt, pad, d, law, N):
        if effects.together[e]:
            address, p, x = _law_of_all(effects, CONTACT, e, i)
            _contact_laws(address, (t, dt, pad, d, law, N, p, x))
            return
        work = effects.work
        for copy in range(COUNT):
            address, p, x = _law_of(effects, CONTACT, e, copy, i)
            if address == 0:
                continue
            _take(d, copy, work[0])
            _take(law, copy, work[1])
            _take(N, copy, work[2])
            _contact_law(
                address,
                (t, dt, pad, work[0, 0:2], work[1, 0:6], work[2, 0:1], p, x),
            )
            _put(work[2], copy, N)

    return each


def call_ring(effects, e, i, t, dt, p_R, r_R, V, F):
    """At a ring."""
    address, p, x = _law_of(effects, RING, e, 0, i)
    _ring_law(address, (t, dt, p_R, r_R, V, F, p, x))


@overload(call_ring, jit_options=_OPTIONS)
def _ring(effects, e, i, t, dt, p_R, r_R, V, F):
    if F.dtype != LANES:
        return call_ring

    def each(effects, e, i, t, dt, p_R, r_R, V, F):
        if effects.together[e]:
            address, p, x = _law_of_all(effects, RING, e, i)
            _ring_laws(address, (t, dt, p_R, r_R, V, F, p, x))
            return
        work = effects.work
        for copy in range(COUNT):
            address, p, x = _law_of(effects, RING, e, copy, i)
            if address == 0:
                continue
            _take(p_R, copy, work[0])
            _take(r_R, copy, work[1])
            _take(V, copy, work[2])
            _take(F, copy, work[3])
            _ring_law(
                address,
                (
                    t,
                    dt,
                    work[0, 0:3],
                    work[1, 0:3],
                    work[2, 0:6],
                    work[3, 0:6],
                    p,
                    x,
                ),
            )
            _put(work[3], copy, F)

    return each


def call_torso(effects, e, t, dt, p_T, r_T, V, law, F):
    """At the torso."""
    address, p, x = _law_of(effects, TORSO, e, 0, 0)
    _torso_law(address, (t, dt, p_T, r_T, V, law, F, p, x))


@overload(call_torso, jit_options=_OPTIONS)
def _torso(effects, e, t, dt, p_T, r_T, V, law, F):
    if F.dtype != LANES:
        return call_torso

    def each(effects, e, t, dt, p_T, r_T, V, law, F):
        if effects.together[e]:
            address, p, x = _law_of_all(effects, TORSO, e, 0)
            _torso_laws(address, (t, dt, p_T, r_T, V, law, F, p, x))
            return
        work = effects.work
        for copy in range(COUNT):
            address, p, x = _law_of(effects, TORSO, e, copy, 0)
            if address == 0:
                continue
            _take(p_T, copy, work[0])
            _take(r_T, copy, work[1])
            _take(V, copy, work[2])
            _take(law, copy, work[3])
            _take(F, copy, work[4])
            _torso_law(
                address,
                (
                    t,
                    dt,
                    work[0, 0:3],
                    work[1, 0:3],
                    work[2, 0:6],
                    work[3, 0:15],
                    work[4, 0:6],
                    p,
                    x,
                ),
            )
            _put(work[4], copy, F)

    return each


def call_sensing(effects, e, i, t, h, u, l, F):  # noqa: E741
    """At a stage's readings."""
    address, p, x = _law_of(effects, SENSING, e, 0, i)
    _sensing_law(address, (t, h, u, l, F, p, x))


@overload(call_sensing, jit_options=_OPTIONS)
def _sensing(effects, e, i, t, h, u, l, F):  # noqa: E741
    if F.dtype != LANES:
        return call_sensing

    def each(effects, e, i, t, h, u, l, F):  # noqa: E741
        if effects.together[e]:
            address, p, x = _law_of_all(effects, SENSING, e, i)
            _sensing_laws(address, (t, h, u, l, F, p, x))
            return
        work = effects.work
        for copy in range(COUNT):
            address, p, x = _law_of(effects, SENSING, e, copy, i)
            if address == 0:
                continue
            _take(u, copy, work[0])
            _take(l, copy, work[1])
            _take(F, copy, work[2])
            _sensing_law(
                address, (t, h, work[0, 0:6], work[1, 0:6], work[2, 0:3], p, x)
            )
            _put(work[1], copy, l)
            _put(work[2], copy, F)

    return each

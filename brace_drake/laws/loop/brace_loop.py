"""The brace in closed loop from one decision of a policy to the next.

The same laws in the same order as the diagram of
`brace_drake.model.brace_station`, which remains the reference (a test holds
both together), compiled for the many episodes of learning. Times are counted
in control ticks: a call takes the plant from the last tick to the one `ticks`
later, which it performs. Where no effect sits at a plug point there is a
kernel of its own: handing functions to compiled code costs as much as a
hundred ticks.
"""

import math

import numpy as np
from numba import boolean, float64, int64, njit, types

from brace_drake.laws import cubic
from brace_drake.laws.compiled import (
    MAKER,
    compiled_law,
    compiled_maker,
    copy_values,
)
from brace_drake.laws.control import brace_control
from brace_drake.laws.hooks import (
    PLUG_POINTS,
    matrix,
    stack_type,
    vector,
    vectors,
)
from brace_drake.laws.loop import blocks, hooked_forces
from brace_drake.laws.loop.kernels import add_brace_legs, calc_brace
from brace_drake.laws.rigid_body import step_free_body
from brace_drake.laws.rotation import quaternion_to_rotation_vector

# What a call comes back with, beside what a tick does.
LOST = 4

# Rotation, velocities and lengths of what moves stay far below this.
_FAR = 1e3


@compiled_law
def read_task_state(inputs, rest, state):
    """Writes X, X' (2, 6n), force first, of the rings' true state.

    Args:
        inputs: As `kernels.calc_brace` takes them, torso included.
        rest: Of each ring (n, 3), m.
        state: Output; X' is [v; w] of the ring.
    """
    n = rest.shape[0]
    at = 7 * (n + 1)
    for i in range(n):
        pose = inputs[7 * i : 7 * i + 7]
        V = inputs[at + 6 * i : at + 6 * i + 6]
        for c in range(3):
            state[0, 6 * i + c] = pose[4 + c] - rest[i, c]
            state[1, 6 * i + c] = V[3 + c]
            state[1, 6 * i + 3 + c] = V[c]
        quaternion_to_rotation_vector(
            pose[0:4], state[0, 6 * i + 3 : 6 * i + 6]
        )


@compiled_law
def step_bodies(inputs, n, forces, mass, dt):
    """Moves n rings and the torso by one plant step under `forces`.

    Args:
        inputs: As above, updated.
        n: Number of rings.
        forces: On each body, torque first (6n + 6,), weight left out.
        mass: Mass, moments (3), weight of each body (n + 1, 5).
        dt: s.
    """
    at = 7 * (n + 1)
    for i in range(n + 1):
        F = forces[6 * i : 6 * i + 6]
        F[5] -= mass[i, 4]
        step_free_body(
            inputs[7 * i : 7 * i + 4],
            inputs[7 * i + 4 : 7 * i + 7],
            inputs[at + 6 * i : at + 6 * i + 6],
            mass[i],
            F,
            dt,
        )


@compiled_law
def is_lost(inputs, n):
    """Whether a body is no longer near where it belongs, or not a number."""
    total = 0.0
    for i in range(13 * (n + 1)):
        total += abs(inputs[i])
    return not (math.isfinite(total) and total < _FAR)


@compiled_maker
def perform_tick(kind, t, times, reference, stiffness, u, law, held, memory):
    """A control tick at t on the readings at hand; see the loops below."""
    pose, virtual, impedance, readings = held
    nc = law.shape[1]
    desired = np.empty(3 * nc)
    cubic.calc_cubic(t, times[1], reference[0], reference[1], desired)
    return brace_control.advance_brace(
        kind, readings[0:nc], readings[nc : nc + nc // 2], desired, stiffness,
        law, pose, memory, virtual, impedance, u,
    )  # fmt: skip


_shared = (
    types.UniTuple(int64, 4),
    types.UniTuple(float64, 2),
    matrix,
    vector,
    vector,
    matrix,
    matrix,
    types.UniTuple(vector, 4),
    matrix,
    vector,
    matrix,
    vector,
)


@njit(int64(*_shared), nogil=True, **MAKER)
def advance_brace_loop(
    counts,
    times,
    reference,
    stiffness,
    inputs,
    mass,
    law,
    held,
    memory,
    resolution,
    noise,
    out,
):
    """Plant steps and control ticks from one decision to the next.

    Args:
        counts: Kind of the controller, index of the last tick, ticks to go,
            plant steps in a tick. With 0 ticks to go the tick of that index is
            performed and nothing moves: the start.
        times: Control period, duration of the desired motion, s.
        reference: X_0, and what the desired motion adds to it (2, 6n).
        stiffness: Asked of the controller (6n,), or (0,).
        inputs: See `kernels.calc_brace`, with torso; plant state and commands
            are updated.
        mass: Mass, moments (3), weight of the rings and the torso (n + 1, 5).
        law: Of the controller, see `brace_control.advance_brace`.
        held: Pose (20n), X_v, X_v', X_v'' (18n), impedance (18n), readings
            (9n + 3), updated.
        memory: Of the controller (rows, 6n), updated.
        resolution: Of lengths, m, and forces, N (2,).
        noise: Of the readings at each tick (ticks, 9n + 3), or (0, 9n + 3).
        out: See `kernels.num_forces`, with the place to work in: as the last
            call has left it. True lengths and forces are in it afterwards.

    Returns:
        What `advance_brace` returns, or LOST.
    """
    kind, last, ticks, steps = counts
    nc = law.shape[1]
    n = nc // 6
    u = inputs[13 * n + 13 : 19 * n + 13]
    dt = times[0] / steps
    F, readings, no_noise = np.empty(6 * n + 6), held[3], np.empty(0)
    for k in range(max(1, ticks)):
        for sub in range(steps if ticks > 0 else 0):
            if sub == 0:
                # The tick has left all other forces behind.
                add_brace_legs(inputs, n, out)
            else:
                calc_brace(inputs, n, True, True, out)
            copy_values(out[0 : 6 * n + 6], F)
            step_bodies(inputs, n, F, mass, dt)
        tick = last + k + 1 if ticks > 0 else last
        if is_lost(inputs, n):
            return LOST
        calc_brace(inputs, n, True, False, out)
        copy_values(out[6 * n + 6 : 15 * n + 9], readings)
        row = noise[tick] if noise.shape[0] > 0 else no_noise
        blocks.read_instruments(resolution, row, readings)
        result = perform_tick(
            kind, tick * times[0], times, reference, stiffness, u, law, held,
            memory,
        )  # fmt: skip
        if result != brace_control.GOOD:
            return result
    return brace_control.GOOD


@njit(
    int64(
        *_shared,
        *[stack_type(point) for point in PLUG_POINTS],
        vectors,
        *[vectors] * len(PLUG_POINTS),
        boolean[:, ::1],
    ),
    nogil=True,
    **MAKER,
)
def advance_hooked_loop(
    counts,
    times,
    reference,
    stiffness,
    inputs,
    mass,
    law,
    held,
    memory,
    resolution,
    noise,
    out,
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
):
    """`advance_brace_loop` of one stage with effects at its plug points.

    Args:
        counts ... out: As there.
        drive ... active: As `rollout_bench` takes them.
    """
    kind, last, ticks, steps = counts
    period = times[0]
    u, own = inputs[26:32], inputs[32:]
    dt = period / steps
    rest, viscous = own[0:3], own[3:9]
    p_WB, p_RT = own[9:27].reshape((6, 3)), own[27:45].reshape((6, 3))
    pads_law, posture = own[45:51], own[51:63]
    R_WR, R_WT = np.empty((3, 3)), np.empty((3, 3))
    lengths, rates, f = np.empty(6), np.empty(6), np.empty(6)
    J, pads, place = np.empty((6, 6)), np.empty((2, 17)), np.empty(6)
    F, F_R, F_T = np.empty(12), np.empty(6), np.empty(6)
    f_T, readings, no_noise = np.zeros(3), held[3], np.empty(0)
    for k in range(max(1, ticks)):
        for sub in range(steps if ticks > 0 else 0):
            t = (last + k) * period + sub * dt
            hooked_forces.calc_hooked_contact(
                t, dt, True, inputs, p_WB, p_RT, pads_law, active,
                compression, contact, parameters, compression_memory,
                contact_memory, R_WR, R_WT, lengths, rates, J, pads, F_R,
                F_T, f_T,
            )  # fmt: skip
            hooked_forces.add_hooked_forces(
                t, dt, True, u, inputs, lengths, rates, J, rest, viscous,
                posture, active, drive, torso, ring, parameters, drive_memory,
                torso_memory, ring_memory, f, place, F_R, F_T,
            )  # fmt: skip
            copy_values(F_R, F[0:6])
            copy_values(F_T, F[6:12])
            step_bodies(inputs, 1, F, mass, dt)
        tick = last + k + 1 if ticks > 0 else last
        t = tick * period
        if is_lost(inputs, 1):
            return LOST
        calc_brace(inputs, 1, False, False, out)
        # A reading sees what the effects do but does not age them.
        hooked_forces.calc_hooked_contact(
            t, dt, True, inputs, p_WB, p_RT, pads_law, active, compression,
            contact, parameters,
            (compression_memory[0].copy(), compression_memory[1].copy()),
            (contact_memory[0].copy(), contact_memory[1].copy()),
            R_WR, R_WT, lengths, rates, J, pads, F_R, F_T, f_T,
        )  # fmt: skip
        copy_values(f_T, out[18:21])
        copy_values(out[12:24], readings)
        row = noise[tick] if noise.shape[0] > 0 else no_noise
        hooked_forces.read_hooked(
            t, period, u, resolution, row, active, sensing, parameters,
            sensing_memory, readings,
        )  # fmt: skip
        result = perform_tick(
            kind, t, times, reference, stiffness, u, law, held, memory
        )
        if result != brace_control.GOOD:
            return result
    return brace_control.GOOD

"""The bench tick by tick, for whoever computes its commands elsewhere.

A tick in two halves: what the instruments read; then, when the commands have
come, the plant's steps until the next tick. The forces are those of
`bench_rollout`, which has the controller inside; a test holds both together
bit by bit.
"""

import math

import numpy as np
from numba import boolean, float64, int64, njit, types

from brace_drake.laws import hooked_forces
from brace_drake.laws.hooks import (
    PLUG_POINTS,
    matrix,
    stack_type,
    vector,
    vectors,
)
from brace_drake.laws.rigid_body import step_free_body_at

# Rest position, viscous, contact, posture, resolution.
_LAWS = types.UniTuple(vector, 5)
_ARGUMENTS = (
    float64,
    int64,
    boolean[::1],
    types.UniTuple(matrix, 2),
    _LAWS,
    types.UniTuple(vector, 2),
    *[stack_type(point) for point in PLUG_POINTS],
    vectors,
    *[vectors] * len(PLUG_POINTS),
    boolean[:, ::1],
    vector,
    vector,
    vector,
    vector,
)


@njit(_ARGUMENTS, cache=True, error_model="numpy")
def run_ticks(
    dt,
    steps,
    with_torso,
    anchors,
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
        anchors: p_WB, p_RT (6, 3), m.
        laws: Rest position (3), viscous (6), contact (6), posture (12),
            resolution (2).
        bodies_mass: Of ring and torso: mass, moments (3), weight (5,).
        drive ... active: As in `rollout_bench`.
        bodies: See `rollout_bench` (26,), updated.
        noise: Of lengths (6), m, force (3), N, marker (3), m; NaN in the first
            place for exact readings (12,).
        readings: Output (12,), as `noise`.
        u: Leg commands (6,), N, read after each yield.

    Yields:
        The tick's number.
    """
    rest, viscous, contact_law, posture_law, resolution = laws
    p_WB, p_RT = anchors
    q_WR, p_WR, q_WT, p_WT = (
        bodies[0:4],
        bodies[4:7],
        bodies[7:11],
        bodies[11:14],
    )
    V_WR, V_WT = bodies[14:20], bodies[20:26]
    R_WR, R_WT, J = np.empty((3, 3)), np.empty((3, 3)), np.empty((6, 6))
    pads, lengths, rates = np.empty((2, 17)), np.empty(6), np.empty(6)
    F_R, F_T, f_T = np.zeros(6), np.zeros(6), np.zeros(3)
    f, pose, no_noise = np.empty(6), np.empty(6), np.empty(0)
    tick, period = 0, dt * steps
    while True:
        for sub in range(steps):
            t = tick * period + sub * dt
            # A torso that has gone leaves no force behind.
            f_T[:] = 0.0
            hooked_forces.calc_hooked_contact(
                t, dt, with_torso[0], bodies, p_WB, p_RT, contact_law, active,
                compression, contact, parameters, compression_memory,
                contact_memory, R_WR, R_WT, lengths, rates, J, pads, F_R, F_T,
                f_T,
            )  # fmt: skip
            if sub == 0:
                readings[0:6] = lengths
                readings[6:9] = f_T
                for i in range(3):
                    readings[9 + i] = p_WT[i] - rest[i]
                hooked_forces.read_hooked(
                    t, period, u, resolution,
                    no_noise if math.isnan(noise[0]) else noise,
                    active, sensing, parameters, sensing_memory, readings,
                )  # fmt: skip
                yield tick
            hooked_forces.add_hooked_forces(
                t, dt, with_torso[0], u, bodies, lengths, rates, J, rest,
                viscous, posture_law, active, drive, torso, ring, parameters,
                drive_memory, torso_memory, ring_memory, f, pose, F_R, F_T,
            )  # fmt: skip
            F_R[5] -= bodies_mass[0][4]
            if with_torso[0]:
                step_free_body_at(
                    R_WT, q_WT, p_WT, V_WT, bodies_mass[1], F_T, dt
                )
            step_free_body_at(R_WR, q_WR, p_WR, V_WR, bodies_mass[0], F_R, dt)
        tick += 1

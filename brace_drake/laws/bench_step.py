"""The bench tick by tick, for whoever computes its commands elsewhere.

A tick in two halves: what the instruments read; then, when the commands have
come, the plant's steps until the next tick. The same blocks in the same order
as `bench_rollout`, which has the controller inside; a test holds both together
bit by bit. (One shared step would cost the rollout half its speed.)
"""

import math

import numpy as np
from numba import boolean, float64, int64, njit, types

from brace_drake.laws import blocks, legs
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    PLUG_POINTS,
    matrix,
    stack_type,
    vector,
    vectors,
)
from brace_drake.laws.rigid_body import step_free_body_at
from brace_drake.laws.rotation import quaternion_to_matrix

_compile = {"cache": True, "error_model": "numpy"}


@njit(**_compile)
def begin_step(
    t,
    dt,
    with_torso,
    bodies,
    anchors,
    contact_law,
    active,
    compression,
    contact,
    parameters,
    compression_memory,
    contact_memory,
    R_WR,
    R_WT,
    J,
    lengths,
    rates,
    pads,
    F_R,
    F_T,
    f_T,
):
    """Writes kinematics and pad forces at the present state.

    Args:
        t, dt: Time and plant step, s.
        with_torso: Whether the torso is there; without it no force is on it.
        bodies: q_WR, p_WR, q_WT, p_WT, V_WR, V_WT (26,).
        anchors: p_WB, p_RT of the plant (6, 3), m.
        contact_law: See `blocks.calc_pad` (6,).
        active ... contact_memory: Effects, as `rollout_bench` takes them.
        R_WR, R_WT, J, lengths, rates, pads, F_R, F_T, f_T: Outputs; of the
            spatial forces, torque first, only the pads' part.
    """
    quaternion_to_matrix(bodies[0:4], R_WR)
    quaternion_to_matrix(bodies[7:11], R_WT)
    legs.calc_leg_kinematics(
        bodies[4:7], R_WR, anchors[0], anchors[1], lengths, J
    )
    legs.calc_leg_rates(J, bodies[14:17], bodies[17:20], rates)
    F_R[:] = 0.0
    F_T[:] = 0.0
    f_T[:] = 0.0
    if with_torso:
        blocks.add_hooked_pads(
            t, dt, bodies, R_WR, R_WT, contact_law, pads, active,
            compression, contact, parameters, compression_memory,
            contact_memory, F_R, F_T, f_T,
        )  # fmt: skip


@njit(**_compile)
def finish_step(
    t,
    dt,
    with_torso,
    u,
    bodies,
    rest,
    viscous,
    posture_law,
    bodies_mass,
    active,
    drive,
    torso,
    ring,
    parameters,
    drive_memory,
    torso_memory,
    ring_memory,
    R_WR,
    R_WT,
    J,
    lengths,
    rates,
    f,
    pose,
    F_R,
    F_T,
):
    """Adds all other forces and steps both bodies.

    Args:
        t, dt, with_torso, bodies: As in `begin_step`; the bodies are updated.
        u: Leg commands (6,), N.
        rest, viscous, posture_law, bodies_mass, active ... ring_memory: As
            `rollout_bench` takes them.
        R_WR, R_WT, J, lengths, rates, F_R, F_T: Of `begin_step`.
        f, pose: Place to work in (6,).
    """
    blocks.calc_leg_forces(u, viscous, rates, f)
    for e in range(MAX_EFFECTS):
        if not active[0, e]:
            continue
        drive[e](
            t, dt, u, lengths, rates, viscous, f,
            parameters[e], drive_memory[e],
        )  # fmt: skip
    legs.add_leg_wrench(J, f, F_R)
    blocks.calc_displacement(bodies[0:4], bodies[4:7], rest, pose)
    for e in range(MAX_EFFECTS):
        if not active[4, e]:
            continue
        ring[e](
            t, dt, pose[0:3], pose[3:6], bodies[14:20], F_R,
            parameters[e], ring_memory[e],
        )  # fmt: skip
    F_R[5] -= bodies_mass[0][4]
    if with_torso:
        blocks.add_posture(bodies, rest, posture_law, pose, F_T)
        for e in range(MAX_EFFECTS):
            if not active[3, e]:
                continue
            torso[e](
                t, dt, pose[0:3], pose[3:6], bodies[20:26], posture_law, F_T,
                parameters[e], torso_memory[e],
            )  # fmt: skip
        step_free_body_at(
            R_WT, bodies[7:11], bodies[11:14], bodies[20:26], bodies_mass[1],
            F_T, dt,
        )  # fmt: skip
    step_free_body_at(
        R_WR, bodies[0:4], bodies[4:7], bodies[14:20], bodies_mass[0], F_R, dt
    )


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


@njit(_ARGUMENTS, **_compile)
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
    R_WR, R_WT, J = np.empty((3, 3)), np.empty((3, 3)), np.empty((6, 6))
    pads, lengths, rates = np.empty((2, 17)), np.empty(6), np.empty(6)
    F_R, F_T, f_T = np.zeros(6), np.zeros(6), np.zeros(3)
    f, pose = np.empty(6), np.empty(6)
    tick, period = 0, dt * steps
    while True:
        for sub in range(steps):
            t = tick * period + sub * dt
            begin_step(
                t, dt, with_torso[0], bodies, anchors, contact_law, active,
                compression, contact, parameters, compression_memory,
                contact_memory, R_WR, R_WT, J, lengths, rates, pads,
                F_R, F_T, f_T,
            )  # fmt: skip
            if sub == 0:
                readings[0:6] = lengths
                readings[6:9] = f_T
                for i in range(3):
                    readings[9 + i] = bodies[11 + i] - rest[i]
                for e in range(MAX_EFFECTS):
                    if not active[5, e]:
                        continue
                    sensing[e](
                        t, period, u, readings[0:6], readings[6:9],
                        parameters[e], sensing_memory[e],
                    )  # fmt: skip
                if not math.isnan(noise[0]):
                    blocks.read_instruments(resolution, noise, readings)
                yield tick
            finish_step(
                t, dt, with_torso[0], u, bodies, rest, viscous, posture_law,
                bodies_mass, active, drive, torso, ring, parameters,
                drive_memory, torso_memory, ring_memory, R_WR, R_WT, J,
                lengths, rates, f, pose, F_R, F_T,
            )  # fmt: skip
        tick += 1

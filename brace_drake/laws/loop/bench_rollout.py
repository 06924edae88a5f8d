"""A whole run of the bench in one compiled call.

The same laws in the same order as the diagram of `brace_drake.model.station`,
which remains the reference (a test holds both together); this is what fits
and diagnoses, thousands of runs, call.
"""

import numpy as np
from numba import boolean, float64, int64, njit, types

from brace_drake.laws.compiled import MAKER, compiled_maker, copy_values
from brace_drake.laws.hooks import (
    PLUG_POINTS,
    matrix,
    stack_type,
    vector,
    vectors,
)
from brace_drake.laws.loop import bench_tick, hooked_forces
from brace_drake.laws.rigid_body import step_free_body_at

# Columns of the log.
NUM_LOGGED = 19


@compiled_maker
def _write_row(row, u, readings, with_torso, virtual):
    for k in range(6):
        row[k] = u[k]
    for i in range(12):
        row[6 + i] = readings[i]
    if not with_torso:
        row[15:18] = 0.0
    row[18] = virtual


@njit(
    int64(
        float64,
        int64,
        int64,
        boolean,
        matrix,
        types.UniTuple(matrix, 2),
        types.UniTuple(vector, 6),
        vectors,
        matrix,
        vector,
        *[stack_type(point) for point in PLUG_POINTS],
        vectors,
        *[vectors] * len(PLUG_POINTS),
        boolean[:, ::1],
        matrix,
    ),
    nogil=True,
    **MAKER,
)
def rollout_bench(
    dt,
    steps_per_tick,
    ticks_per_sample,
    with_torso,
    desired,
    anchors,
    laws,
    bodies_mass,
    noise,
    bodies,
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
    log,
):
    """Simulates one run and writes its log.

    Args:
        dt: Plant step, s.
        steps_per_tick, ticks_per_sample: Plant steps in a control period,
            control periods in a logged sample.
        with_torso: Whether the torso is there.
        desired: Reference y, y', y'' at each tick (ticks, 3).
        anchors: p_WB, p_RT of the plant (6, 3), m.
        laws: Rest position (3), viscous (6), contact (6), posture (12),
            controller (102), resolution (2).
        bodies_mass: Mass, moments (3), weight of ring and torso (5,).
        noise: Reading noise at each tick (ticks, 12), or (0, 12).
        bodies: Initial q_WR, p_WR, q_WT, p_WT, V_WR, V_WT (26,), updated.
        drive ... sensing: Laws of the effects at each plug point.
        parameters: Parameters of each effect.
        drive_memory ... sensing_memory: Their states, updated.
        active: Whether an effect sits at a plug point (points, MAX_EFFECTS).
        log: Output (samples, 19): commands (6), N; lengths (6), m; force
            (3), N; marker (3), m; virtual position, m.

    Returns:
        -1 when all went well, else the tick at which the run broke down.
    """
    p_WB, p_RT = anchors
    rest, viscous, contact_law, posture_law, control_law, resolution = laws
    q_WR, p_WR, q_WT, p_WT = (
        bodies[0:4],
        bodies[4:7],
        bodies[7:11],
        bodies[11:14],
    )
    V_WR, V_WT = bodies[14:20], bodies[20:26]
    mass_R, mass_T = bodies_mass[0], bodies_mass[1]
    J, pose = np.empty((6, 6)), np.empty(6)
    R_WR, R_WT = np.empty((3, 3)), np.empty((3, 3))
    lengths, rates, f, u = np.empty(6), np.empty(6), np.zeros(6), np.zeros(6)
    F_R, F_T, f_T = np.zeros(6), np.zeros(6), np.zeros(3)
    pads, ideal, readings = np.empty((2, 17)), np.zeros(12), np.zeros(12)
    memory = bench_tick.make_memory(rest)
    controller = bench_tick.make_controller(control_law, memory)
    no_noise = np.empty(0)
    period = dt * steps_per_tick
    for tick in range(desired.shape[0]):
        for sub in range(steps_per_tick):
            t = tick * period + sub * dt
            hooked_forces.calc_hooked_contact(
                t, dt, with_torso, bodies, p_WB, p_RT, contact_law, active,
                compression, contact, parameters, compression_memory,
                contact_memory, R_WR, R_WT, lengths, rates, J, pads, F_R, F_T,
                f_T,
            )  # fmt: skip
            if sub == 0:
                copy_values(lengths, ideal[0:6])
                copy_values(f_T, ideal[6:9])
                for i in range(3):
                    ideal[9 + i] = p_WT[i] - rest[i]
                copy_values(ideal, readings)
                hooked_forces.read_hooked(
                    t, period, u, resolution,
                    noise[tick] if noise.shape[0] > 0 else no_noise,
                    active, sensing, parameters, sensing_memory, readings,
                )  # fmt: skip
                if not bench_tick.advance_tick(
                    readings, desired[tick], controller, u
                ):
                    return tick
                if tick % ticks_per_sample == 0:
                    row = log[tick // ticks_per_sample]
                    y_virtual = memory[bench_tick.Y_VIRTUAL]
                    _write_row(row, u, readings, with_torso, y_virtual)
            hooked_forces.add_hooked_forces(
                t, dt, with_torso, u, bodies, lengths, rates, J, rest, viscous,
                posture_law, active, drive, torso, ring, parameters,
                drive_memory, torso_memory, ring_memory, f, pose, F_R, F_T,
            )  # fmt: skip
            F_R[5] -= mass_R[4]
            if with_torso:
                step_free_body_at(R_WT, q_WT, p_WT, V_WT, mass_T, F_T, dt)
            step_free_body_at(R_WR, q_WR, p_WR, V_WR, mass_R, F_R, dt)
        if not abs(p_WR[1]) + abs(p_WT[1]) < 1.0:
            return tick
    return -1

"""The laws of a plant step and of a tick, each in one call from a LeafSystem.

A call from Python into compiled code pays for each array that it hands over,
and small arrays made inside cost as much as what they hold: so a system hands
over few, with the place to work in among them.
"""

import numpy as np
from numba import njit

from brace_drake.laws import blocks, controller, legs
from brace_drake.laws.rotation import quaternion_to_matrix

_compile = {"cache": True, "error_model": "numpy"}

# Law of the forces: rest position (3), viscous (6), p_WB (18), p_RT (18),
# contact (6), posture (12).
NUM_BENCH_LAW = 63
# A bench's forces and signals: F on the ring (6) and on the torso (6), torque
# first; leg lengths (6), force of the ring on the torso (3), displacement and
# rotation vector of the torso (6). Then a place to work in: Jacobian (36),
# rates (6), leg forces (6), pads (34), rotations of ring and torso (18).
NUM_BENCH = 27
NUM_BENCH_WITH_WORK = NUM_BENCH + 100
# Law of a tick: resolution (2), noise sigma (12), then `controller.NUM_LAW`.
NUM_TICK_LAW = 14 + controller.NUM_LAW
# A tick's results: leg command (6), readings (12), then the memories of the
# impedance filter (4) and of the pose estimator (20).
NUM_TICK = 18 + controller.NUM_MEMORY


@njit(**_compile)
def add_absent_torso(state):
    """The state (13,) of the ring alone as that of both bodies (26,)."""
    bodies = np.zeros(26)
    bodies[0:7] = state[0:7]
    bodies[14:20] = state[7:13]
    return bodies


@njit(**_compile)
def calc_bench(inputs, with_pads, out):
    """All nominal forces of the bench, and what its instruments see.

    Args:
        inputs: q, p of ring and, where present, torso, then [w; v] of each
            (13) or (26); held leg commands (6), N; law, see NUM_BENCH_LAW.
        with_pads: Whether pads press on the torso.
        out: See NUM_BENCH, overwritten, with the place to work in behind it;
            the torso's part is left alone where it is absent.
    """
    n = inputs.shape[0] - NUM_BENCH_LAW - 6
    state, u, law = inputs[0:n], inputs[n : n + 6], inputs[n + 6 :]
    with_torso = n == 26
    bodies = state if with_torso else add_absent_torso(state)
    F_R_W, F_T_W, f_T_W = out[0:6], out[6:12], out[18:21]
    J, rates, f = out[27:63].reshape((6, 6)), out[63:69], out[69:75]
    R_WR = out[109:118].reshape((3, 3))
    out[0:12] = 0.0
    out[18:21] = 0.0
    quaternion_to_matrix(bodies[0:4], R_WR)
    legs.calc_leg_kinematics(
        bodies[4:7],
        R_WR,
        law[9:27].reshape((6, 3)),
        law[27:45].reshape((6, 3)),
        out[12:18],
        J,
    )
    legs.calc_leg_rates(J, bodies[14:17], bodies[17:20], rates)
    if with_pads:
        R_WT = out[118:127].reshape((3, 3))
        quaternion_to_matrix(bodies[7:11], R_WT)
        pads = out[75:109].reshape((2, 17))
        blocks.add_pads_at(
            bodies, R_WR, R_WT, law[45:51], pads, F_R_W, F_T_W, f_T_W
        )
    blocks.calc_leg_forces(u, law[3:9], rates, f)
    legs.add_leg_wrench(J, f, F_R_W)
    if with_torso:
        blocks.add_posture(bodies, law[0:3], law[51:63], out[21:27], F_T_W)


@njit(**_compile)
def advance_tick(measured, desired, noise, law, tick):
    """One control tick: from readings to commands.

    Args:
        measured: Leg lengths (6), m, force (3), N, marker (3), m: (12,).
        desired: y_d, y_d', y_d'' (3,).
        noise: Standard normal draws (12,), or (0,) for exact readings.
        law: See NUM_TICK_LAW.
        tick: See NUM_TICK, updated.

    Returns:
        False where no pose was found or the legs are singular.
    """
    readings = tick[6:18]
    readings[:] = measured
    if noise.shape[0] > 0:
        blocks.read_instruments(law[0:2], noise * law[2:14], readings)
    return controller.advance(
        readings,
        desired,
        law[14:],
        tick[22:],
        tick[18:22],
        np.empty(19),
        tick[0:6],
    )

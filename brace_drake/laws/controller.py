"""The controller's tick in three compiled steps, as the diagram takes them.

pose estimator -> impedance filter -> inverse dynamics
"""

import numpy as np
from numba import njit

from brace_drake.laws import control, legs
from brace_drake.laws.rotation import (
    quaternion_to_matrix,
    quaternion_to_rotation_vector,
    rotate_quaternion,
)

# Sizes of what each step remembers from tick to tick.
NUM_POSE_MEMORY = 20  # p_WR (3), q_WR (4), X previous (6), V (6), started
NUM_IMPEDANCE_MEMORY = 4  # filtered force, y_v, y_v', y_v''


@njit(cache=True, error_model="numpy")
def estimate_pose(lengths, law, p_WB, p_RT, memory, estimate):
    """Forward kinematics of the leg lengths and the filtered rate.

    Args:
        lengths: Measured (6,), m.
        law: Rest position (3), period, velocity gain: (5,).
        p_WB, p_RT: Anchors as the controller knows them (6, 3), m.
        memory: See NUM_POSE_MEMORY, updated.
        estimate: Output (19,): X (6), V (6), p_WR (3), q_WR (4).

    Returns:
        False where the pose could not be found.
    """
    # The search sets out from where the ring should be by now.
    for i in range(3):
        memory[i] += law[3] * memory[13 + i]
    rotate_quaternion(
        memory[3:7],
        law[3] * memory[16],
        law[3] * memory[17],
        law[3] * memory[18],
    )
    good = legs.solve_forward_kinematics(
        lengths, p_WB, p_RT, memory[0:3], memory[3:7]
    )
    for i in range(3):
        estimate[i] = memory[i] - law[i]
    quaternion_to_rotation_vector(memory[3:7], estimate[3:6])
    if memory[19] == 0.0:
        # Before the first tick there is nothing to difference with.
        memory[19] = 1.0
        memory[7:13] = estimate[0:6]
    control.update_velocity_estimate(
        estimate[0:6], memory[7:13], memory[13:19], law[4], law[3]
    )
    for i in range(6):
        estimate[6 + i] = memory[13 + i]
    for i in range(7):
        estimate[12 + i] = memory[i]
    return good


@njit(cache=True, error_model="numpy")
def filter_impedance(force, desired, law, memory):
    """Low-passes the force, then takes one step of equation (5).

    Args:
        force: Measured force along the axis, N.
        desired: y_d, y_d', y_d'' (3,).
        law: M_d, C_d, K_d, force gain, period: (5,).
        memory: See NUM_IMPEDANCE_MEMORY, updated; it is the output as well.
    """
    memory[0] += law[3] * (force - memory[0])
    control.update_impedance(
        law[0], law[1], law[2], desired, memory[0], law[4], memory[1:4]
    )


@njit(cache=True, error_model="numpy")
def calc_leg_commands(estimate, impedance, law, p_WB, p_RT, commands):
    """Inverse dynamics (6) at the estimated pose, sent to the legs.

    Args:
        estimate: As `estimate_pose` writes it (19,).
        impedance: Filtered force, y_v, y_v', y_v'' (4,).
        law: kp, kd, diagonal of M (6), weight, force limit: (10,).
        p_WB, p_RT: Anchors as the controller knows them (6, 3), m.
        commands: Output (6,), N.

    Returns:
        False where the Jacobian is singular.
    """
    F = np.empty(6)
    lengths = np.empty(6)
    R_WR = np.empty((3, 3))
    J = np.empty((6, 6))
    scratch = np.empty((6, 6))
    control.calc_task_force(
        estimate[0:6],
        estimate[6:12],
        impedance[1:4],
        impedance[0],
        law[2:8],
        law[8],
        law[0],
        law[1],
        1,
        F,
    )
    quaternion_to_matrix(estimate[15:19], R_WR)
    legs.calc_leg_kinematics(estimate[12:15], R_WR, p_WB, p_RT, lengths, J)
    return control.distribute_to_legs(J, scratch, F, law[9], commands)


# The whole controller's memory: pose estimator, then impedance filter.
NUM_MEMORY = NUM_POSE_MEMORY + NUM_IMPEDANCE_MEMORY
# Its law: estimator (5), impedance (5), inverse dynamics (10), p_WB, p_RT.
NUM_LAW = 56


@njit(cache=True, error_model="numpy")
def advance(readings, desired, law, pose, virtual, estimate, commands):
    """All three steps of one tick.

    Args:
        readings: Leg lengths (6), m, force (3), N, marker (3), m.
        desired: y_d, y_d', y_d'' (3,).
        law: See NUM_LAW.
        pose: See NUM_POSE_MEMORY, updated.
        virtual: See NUM_IMPEDANCE_MEMORY, updated.
        estimate: Output (19,), as `estimate_pose` writes it.
        commands: Output (6,), N.

    Returns:
        False where no pose was found or the legs are singular.
    """
    p_WB, p_RT = law[20:38].reshape((6, 3)), law[38:56].reshape((6, 3))
    good = estimate_pose(readings[0:6], law[0:5], p_WB, p_RT, pose, estimate)
    filter_impedance(readings[7], desired, law[5:10], virtual)
    return good and calc_leg_commands(
        estimate, virtual, law[10:20], p_WB, p_RT, commands
    )


@njit(cache=True, error_model="numpy")
def control_tick(readings, desired, law, memory, estimate, commands):
    """`advance` with both memories in one, see NUM_MEMORY."""
    return advance(
        readings,
        desired,
        law,
        memory[0:NUM_POSE_MEMORY],
        memory[NUM_POSE_MEMORY:NUM_MEMORY],
        estimate,
        commands,
    )

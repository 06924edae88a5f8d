"""One tick of any of the brace's controllers: leg lengths in, leg forces out.

pose estimator -> virtual poses -> task forces -> legs

For S stages with n = S moving rings. All arrays over task coordinates have 6n
columns, ring by ring from the bottom (see `task_impedance`); the law and what
is remembered are stacks of such rows.
"""

import numpy as np
from numba import njit

from brace_drake.laws import controller, pid, stages, task_impedance
from brace_drake.laws.mraic import (
    NUM_MRAIC_LAW,
    NUM_MRAIC_MEMORY,
    advance_mraic,
)
from brace_drake.laws.npic import NUM_NPIC_LAW, NUM_NPIC_MEMORY, advance_npic
from brace_drake.laws.rotation import quaternion_to_matrix
from brace_drake.laws.vpic import NUM_VPIC_LAW, NUM_VPIC_MEMORY, advance_vpic

_compile = {"cache": True, "error_model": "numpy"}

# Kinds of controllers.
IDC, PIC, MRAIC, NPIC, VPIC, PID = range(6)

# Rows of the law that all kinds share. ESTIMATOR: of each ring position at
# rest (3), period, gains of the low passes of velocity and force.
ESTIMATOR, SELECTED, FED_FORWARD, M_D, C_D, K_D = range(6)
K_P, K_V, MASS, GRAVITY, LIMIT = range(6, 11)
LOWER, UPPER = 11, 14  # anchors as the controller knows them, 3 rows each
NUM_SHARED_LAW = 17

# Rows behind them, and rows of memory behind the filtered force, by kind.
NUM_OWN_LAW = (
    0,
    0,
    NUM_MRAIC_LAW,
    NUM_NPIC_LAW,
    NUM_VPIC_LAW,
    pid.NUM_PID_LAW,
)
NUM_OWN_MEMORY = (
    0,
    0,
    NUM_MRAIC_MEMORY,
    NUM_NPIC_MEMORY,
    NUM_VPIC_MEMORY,
    pid.NUM_PID_MEMORY,
)

# What a tick comes back with.
GOOD, NO_POSE, SINGULAR, BAD_STIFFNESS = range(4)


@njit(**_compile)
def estimate_rings(lengths, law, pose, poses, state):
    """Poses of all rings, from the lowest up, and their filtered rates.

    Args:
        lengths: Measured (6n,), m.
        law: Shared rows.
        pose: Memory of each ring's estimator (n, 20), updated, see
            `controller.NUM_POSE_MEMORY`.
        poses: Output q_WR, p_WR (n, 7).
        state: Output X, X' (2, 6n).

    Returns:
        False where a pose could not be found.
    """
    n = pose.shape[0]
    estimator = law[ESTIMATOR].reshape((n, 6))
    lower = law[LOWER : LOWER + 3].reshape((n, 6, 3))
    upper = law[UPPER : UPPER + 3].reshape((n, 6, 3))
    p_WB, R, estimate = np.empty((6, 3)), np.empty((3, 3)), np.empty(19)
    for i in range(n):
        anchors = lower[0]
        if i > 0:
            quaternion_to_matrix(poses[i - 1, 0:4], R)
            stages.place_lower_anchors(poses[i - 1], R, lower[i], p_WB)
            anchors = p_WB
        own = lengths[6 * i : 6 * i + 6]
        if not controller.estimate_pose(
            own, estimator[i], anchors, upper[i], pose[i], estimate
        ):
            return False
        for c in range(6):
            state[0, 6 * i + c] = estimate[c]
            state[1, 6 * i + c] = estimate[6 + c]
        for c in range(4):
            poses[i, c] = estimate[15 + c]
        for c in range(3):
            poses[i, 4 + c] = estimate[12 + c]
    return True


@njit(**_compile)
def filter_force(force, gain, filtered):
    """Low pass of the rings' forces (3n,) into rows with torques (6n,)."""
    for i in range(force.shape[0]):
        k = 6 * (i // 3) + i % 3
        filtered[k] += gain * (force[i] - filtered[k])


@njit(**_compile)
def send_to_legs(F, poses, law, command):
    """Leg commands f = J^-T F at the estimated poses, each leg limited.

    Legs of stage i push ring i and pull back ring i - 1, so the stages are
    solved from the top down.

    Returns:
        False where a stage is singular.
    """
    n = poses.shape[0]
    lower = law[LOWER : LOWER + 3].reshape((n, 6, 3))
    upper = law[UPPER : UPPER + 3].reshape((n, 6, 3))
    R, p_WB = np.empty((n, 3, 3)), np.empty((n, 6, 3))
    J, J_L = np.empty((n, 6, 6)), np.empty((n, 6, 6))
    stages.calc_kinematics(
        poses, lower, upper, R, p_WB, np.empty(6 * n), J, J_L
    )
    if not stages.solve_leg_forces(J, J_L, F, np.empty((6, 6)), command):
        return False
    for k in range(6 * n):
        limit = law[LIMIT, k]
        command[k] = min(limit, max(-limit, command[k]))
    return True


@njit(**_compile)
def advance_virtual(
    kind, desired, state, force, stiffness, law, memory, virtual, impedance
):
    """Virtual poses and impedance in use of every kind but PID.

    Returns:
        False where a stiffness asked for is not a number.
    """
    period, selected = law[ESTIMATOR, 3], law[SELECTED]
    wanted, own = law[M_D : K_D + 1], law[NUM_SHARED_LAW:]
    if kind == PIC:
        task_impedance.advance_pic(
            desired, force, period, selected, wanted[0], wanted[1], wanted[2],
            virtual, impedance,
        )  # fmt: skip
    elif kind == MRAIC:
        advance_mraic(
            desired, state, force, period, selected, wanted, own, memory,
            virtual, impedance,
        )  # fmt: skip
    elif kind == NPIC:
        advance_npic(
            desired, state, force, period, selected, wanted, own, memory,
            virtual, impedance,
        )  # fmt: skip
    elif kind == VPIC:
        return advance_vpic(
            desired, state, force, stiffness, period, selected, wanted, own,
            memory, virtual, impedance,
        )  # fmt: skip
    else:
        task_impedance.advance_idc(desired, virtual, impedance)
    return True


@njit(**_compile)
def is_saturated(command, limit):
    """Whether a leg is at its limit."""
    for k in range(command.shape[0]):
        if abs(command[k]) >= limit[k]:
            return True
    return False


@njit(**_compile)
def advance_brace(
    kind,
    lengths,
    force,
    desired,
    stiffness,
    law,
    pose,
    memory,
    virtual,
    impedance,
    command,
):
    """One tick.

    Args:
        kind: IDC, PIC, MRAIC, NPIC, VPIC or PID.
        lengths: Measured (6n,), m.
        force: Measured force of each ring on the torso in W (3n,), N.
        desired: X_d, X_d', X_d'' (18n,).
        stiffness: Asked for from outside (6n,), or (0,); VPIC alone uses it.
        law: Rows of the kind (rows, 6n).
        pose: Memory of the estimator (20n,), updated.
        memory: Rows of the kind, the filtered force first (rows, 6n), updated.
        virtual: X_v, X_v', X_v'' (18n,), updated.
        impedance: M_d, C_d, K_d in use (18n,), 0 where there is none; output.
        command: Leg forces (6n,), N: of the last tick, and output.

    Returns:
        GOOD, NO_POSE, SINGULAR or BAD_STIFFNESS.
    """
    nc = lengths.shape[0]
    n = nc // 6
    X_d, X_v = desired.reshape((3, nc)), virtual.reshape((3, nc))
    used = impedance.reshape((3, nc))
    poses, state, F = np.empty((n, 7)), np.empty((2, nc)), np.empty(nc)
    if not estimate_rings(lengths, law, pose.reshape((n, 20)), poses, state):
        return NO_POSE
    filtered, own = memory[0], memory[1:]
    filter_force(force, law[ESTIMATOR, 5], filtered)
    if kind == PID:
        task_impedance.advance_idc(X_d, X_v, used)
        pid.advance_pid(
            X_d, state, filtered, law[ESTIMATOR, 3],
            is_saturated(command, law[LIMIT]),
            law[NUM_SHARED_LAW:], law[GRAVITY], own, F,
        )  # fmt: skip
    else:
        if not advance_virtual(
            kind, X_d, state, filtered, stiffness, law, own, X_v, used
        ):
            return BAD_STIFFNESS
        task_impedance.calc_task_forces(
            state, X_v, filtered, law[FED_FORWARD],
            law[K_P : K_V + 1], law[MASS], law[GRAVITY], F,
        )  # fmt: skip
    return GOOD if send_to_legs(F, poses, law, command) else SINGULAR

"""One tick of any of the brace's controllers: leg lengths in, leg forces out.

pose estimator -> virtual poses -> task forces -> legs

For S stages with n = S moving rings. All arrays over task coordinates have 6n
columns, ring by ring from the bottom (see `task_impedance`); the law and what
is remembered are stacks of such rows.
"""

import numpy as np

from brace_drake.laws import stages
from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.control import pid, pose_estimate, task_impedance
from brace_drake.laws.control.mraic import (
    NUM_MRAIC_LAW,
    NUM_MRAIC_MEMORY,
    advance_mraic,
)
from brace_drake.laws.control.npic import (
    NUM_NPIC_LAW,
    NUM_NPIC_MEMORY,
    advance_npic,
)
from brace_drake.laws.control.vpic import (
    NUM_VPIC_LAW,
    NUM_VPIC_MEMORY,
    advance_vpic,
)
from brace_drake.laws.rotation import quaternion_to_matrix

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


@compiled_maker
def take_work(n):
    """Places to work in for a tick of n rings, made in one piece.

    That is poses (n, 7), X and X' (2, 6n), task forces (6n,); and those of
    `estimate_rings` and `send_to_legs`: R (n, 3, 3), lower anchors (n, 6, 3),
    leg lengths (6n,), J and J_L (n, 6, 6), a matrix (6, 6), an estimate (19,).
    """
    work = np.empty(130 * n + 55)
    poses = work[0 : 7 * n].reshape((n, 7))
    state = work[7 * n : 19 * n].reshape((2, 6 * n))
    F = work[19 * n : 25 * n]
    R = work[25 * n : 34 * n].reshape((n, 3, 3))
    p_WB = work[34 * n : 52 * n].reshape((n, 6, 3))
    lengths = work[52 * n : 58 * n]
    J = work[58 * n : 94 * n].reshape((n, 6, 6))
    J_L = work[94 * n : 130 * n].reshape((n, 6, 6))
    scratch = work[130 * n : 130 * n + 36].reshape((6, 6))
    estimate = work[130 * n + 36 :]
    return poses, state, F, (R, p_WB, lengths, J, J_L, scratch, estimate)


@compiled_maker
def take_geometry(law, n):
    """Rows of the law as they are used: estimator, lower, upper anchors.

    That is (n, 6), (n, 6, 3), (n, 6, 3). To look at an array in another shape
    costs as much as some of the laws: a loop over ticks does it once.
    """
    estimator = law[ESTIMATOR].reshape((n, 6))
    lower = law[LOWER : LOWER + 3].reshape((n, 6, 3))
    upper = law[UPPER : UPPER + 3].reshape((n, 6, 3))
    return estimator, lower, upper


@compiled_law
def estimate_rings(lengths, geometry, pose, poses, state, work):
    """Poses of all rings, from the lowest up, and their filtered rates.

    Args:
        lengths: Measured (6n,), m.
        geometry: See `take_geometry`.
        pose: Memory of each ring's estimator (n, 20), updated, see
            `pose_estimate.NUM_POSE_MEMORY`.
        poses: Output q_WR, p_WR (n, 7).
        state: Output X, X' (2, 6n).
        work: See `take_work`.

    Returns:
        False where a pose could not be found.
    """
    n = pose.shape[0]
    estimator, lower, upper = geometry
    R, p_WB, at_pose, J, _, scratch, estimate = work
    for i in range(n):
        anchors = lower[0]
        if i > 0:
            quaternion_to_matrix(poses[i - 1, 0:4], R[i])
            stages.place_lower_anchors(poses[i - 1], R[i], lower[i], p_WB[i])
            anchors = p_WB[i]
        own = lengths[6 * i : 6 * i + 6]
        place = R[i], J[i], at_pose[0:6], scratch[0]
        if not pose_estimate.estimate_pose(
            own, estimator[i], anchors, upper[i], pose[i], estimate, place
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


@compiled_law
def filter_force(force, gain, filtered):
    """Low pass of the rings' forces (3n,) into rows with torques (6n,)."""
    for i in range(force.shape[0]):
        k = 6 * (i // 3) + i % 3
        filtered[k] += gain * (force[i] - filtered[k])


@compiled_law
def send_to_legs(F, poses, geometry, limit, work, command):
    """Leg commands f = J^-T F at the estimated poses, each leg limited.

    Legs of stage i push ring i and pull back ring i - 1, so the stages are
    solved from the top down.

    Returns:
        GOOD, or SINGULAR where a stage is.
    """
    _, lower, upper = geometry
    R, p_WB, lengths, J, J_L, scratch, _ = work
    stages.calc_kinematics(poses, lower, upper, R, p_WB, lengths, J, J_L)
    if not stages.solve_leg_forces(J, J_L, F, scratch, command):
        return SINGULAR
    for k in range(command.shape[0]):
        command[k] = min(limit[k], max(-limit[k], command[k]))
    return GOOD


@compiled_law
def follow_virtual(
    X_v, filtered, law, geometry, poses, state, F, work, command
):
    """Inverse dynamics (6) from the estimated state to X_v (3, 6n).

    Returns:
        GOOD or SINGULAR.
    """
    task_impedance.calc_task_forces(
        state, X_v, filtered, law[FED_FORWARD],
        law[K_P : K_V + 1], law[MASS], law[GRAVITY], F,
    )  # fmt: skip
    return send_to_legs(F, poses, geometry, law[LIMIT], work, command)


@compiled_law
def advance_virtual(
    kind, desired, state, force, stiffness, law, memory, virtual, impedance
):
    """Virtual poses and impedance in use of every kind but PIC and PID.

    Returns:
        False where a stiffness asked for is not a number.
    """
    period, selected = law[ESTIMATOR, 3], law[SELECTED]
    wanted, own = law[M_D : K_D + 1], law[NUM_SHARED_LAW:]
    if kind == MRAIC:
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


@compiled_law
def is_saturated(command, limit):
    """Whether a leg is at its limit."""
    for k in range(command.shape[0]):
        if abs(command[k]) >= limit[k]:
            return True
    return False


@compiled_law
def advance_brace_pic(
    lengths,
    force,
    X_d,
    law,
    geometry,
    rings,
    filtered,
    X_v,
    impedance,
    places,
    command,
):
    """One tick of PIC: the bench's, with n = 1, and the brace's.

    Args:
        X_d, X_v, impedance: As in `advance_brace`, a row each (3, 6n).
        geometry: See `take_geometry`.
        rings: Memory of each ring's estimator (n, 20), updated.
        filtered: Filtered force (6n,), N, updated.
        places: To work in, see `take_work`.
        lengths ... command: As in `advance_brace`.

    Returns:
        GOOD, NO_POSE or SINGULAR.
    """
    poses, state, F, work = places
    if not estimate_rings(lengths, geometry, rings, poses, state, work):
        return NO_POSE
    filter_force(force, law[ESTIMATOR, 5], filtered)
    task_impedance.advance_pic(
        X_d, filtered, law[ESTIMATOR, 3], law[SELECTED],
        law[M_D], law[C_D], law[K_D], X_v, impedance,
    )  # fmt: skip
    return follow_virtual(
        X_v, filtered, law, geometry, poses, state, F, work, command
    )


@compiled_maker
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
    filtered, own = memory[0], memory[1:]
    nc = lengths.shape[0]
    n = nc // 6
    X_d, X_v = desired.reshape((3, nc)), virtual.reshape((3, nc))
    used = impedance.reshape((3, nc))
    geometry, places = take_geometry(law, n), take_work(n)
    poses, state, F, work = places
    rings = pose.reshape((n, pose_estimate.NUM_POSE_MEMORY))
    if kind == PIC:
        return advance_brace_pic(
            lengths, force, X_d, law, geometry, rings, filtered, X_v, used,
            places, command,
        )  # fmt: skip
    if not estimate_rings(lengths, geometry, rings, poses, state, work):
        return NO_POSE
    filter_force(force, law[ESTIMATOR, 5], filtered)
    if kind == PID:
        task_impedance.advance_idc(X_d, X_v, used)
        pid.advance_pid(
            X_d, state, filtered, law[ESTIMATOR, 3],
            is_saturated(command, law[LIMIT]),
            law[NUM_SHARED_LAW:], law[GRAVITY], own, F,
        )  # fmt: skip
        return send_to_legs(F, poses, geometry, law[LIMIT], work, command)
    if not advance_virtual(
        kind, X_d, state, filtered, stiffness, law, own, X_v, used
    ):
        return BAD_STIFFNESS
    return follow_virtual(
        X_v, filtered, law, geometry, poses, state, F, work, command
    )

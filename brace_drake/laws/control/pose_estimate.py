"""The rings' poses and velocities from their leg lengths, tick by tick."""

from brace_drake.laws import legs, stages
from brace_drake.laws.compiled import compiled_law, copy_values
from brace_drake.laws.control import impedance as control
from brace_drake.laws.lanes.functions import lead
from brace_drake.laws.rotation import (
    quaternion_to_matrix,
    quaternion_to_rotation_vector,
    rotate_quaternion,
)

# What is remembered from tick to tick: p_WR (3), q_WR (4), X of the last tick
# (6), V (6), whether there was one.
NUM_POSE_MEMORY = 20


@compiled_law
def estimate_pose(lengths, law, p_WB, p_RT, memory, estimate, place):
    """Forward kinematics of the leg lengths and the filtered rate.

    Args:
        lengths: Measured (6,), m.
        law: Rest position (3), period, velocity gain: (5,).
        p_WB, p_RT: Anchors as the controller knows them (6, 3), m.
        memory: See NUM_POSE_MEMORY, updated.
        estimate: Output (19,): X (6), V (6), p_WR (3), q_WR (4).
        place: To work in, see `legs.search_pose`.

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
    good = legs.search_pose(
        lengths, p_WB, p_RT, memory[0:3], memory[3:7], place
    )
    for i in range(3):
        estimate[i] = memory[i] - law[i]
    quaternion_to_rotation_vector(memory[3:7], estimate[3:6])
    if lead(memory[19]) == 0.0:
        # Before the first tick there is nothing to difference with.
        memory[19] = 1.0
        copy_values(estimate[0:6], memory[7:13])
    control.update_velocity_estimate(
        estimate[0:6], memory[7:13], memory[13:19], law[4], law[3]
    )
    for i in range(6):
        estimate[6 + i] = memory[13 + i]
    for i in range(7):
        estimate[12 + i] = memory[i]
    return good


@compiled_law
def estimate_rings(lengths, geometry, pose, poses, state, work):
    """Poses of all rings, from the lowest up, and their filtered rates.

    Args:
        lengths: Measured (6n,), m.
        geometry: See `brace_control.take_geometry`.
        pose: Memory of each ring's estimator (n, 20), updated, see
            NUM_POSE_MEMORY.
        poses: Output q_WR, p_WR (n, 7).
        state: Output X, X' (2, 6n).
        work: See `brace_control.take_work`.

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
        if not estimate_pose(
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

"""A ring's pose and velocity from its leg lengths, tick by tick."""

from brace_drake.laws import legs
from brace_drake.laws.compiled import compiled_law, copy_values
from brace_drake.laws.control import impedance as control
from brace_drake.laws.rotation import (
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
    if memory[19] == 0.0:
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

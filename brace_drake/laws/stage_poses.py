"""Forward kinematics of stages: Newton's method along a path of lengths.

From a pose whose lengths are known, the lengths go to the given ones on a
straight line, in steps that the theorem of Newton and Kantorovich admits
(Ortega and Rheinboldt, 1970, 12.6.2). With xi = (v, L w) the change of pose,
L the largest |p_RT|, b a bound on |J^-1| and K a Lipschitz constant of the
Jacobian on the ball that the theorem looks at, a step from a pose that is
d = J^-1 (l - l(pose)) short is taken where b K |d| <= 1/4. Then a pose with
these lengths exists, is the only one within that ball, and Newton's method
from where it stands converges to it quadratically. So the pose that is found
is the one that the mechanism goes to when its legs move so from the start: no
singularity is crossed, and no other way of assembly is taken.

K: along a line in (v, w) the leg vector d(s) has |d'| <= |v| + |T| |w| and
|d''| <= |T| |w|^2, and l'' <= |d'|^2 / l + |d''| <= (2 / l + 1 / L) |xi|^2.
"""

import numpy as np

from brace_drake.laws import legs
from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.linear_solve import solve_in_place
from brace_drake.laws.rotation import quaternion_to_matrix
from brace_drake.laws.stages import place_lower_anchors

_ADMITTED = 0.25  # of b K |d|; the theorem takes 1/2
MAX_STEPS = 400


@compiled_law
def _invert_scaled(J, L, inverse, scratch):
    """Writes the inverse of J in scaled coordinates; False if singular."""
    for c in range(6):
        for r in range(6):
            for k in range(3):
                scratch[r, k] = J[r, k]
                scratch[r, 3 + k] = J[r, 3 + k] / L
        inverse[c, :] = 0.0
        inverse[c, c] = 1.0
        # Rows of `inverse` hold the columns of the true one.
        if not solve_in_place(scratch, inverse[c]):
            return False
    return True


@compiled_law
def admit_step(lengths, goal, J, L, inverse, scratch):
    """How much of the way from `lengths` to `goal` one step may take.

    Args:
        lengths, goal: At the pose, and wanted (6,), m.
        J: Jacobian at the pose (6, 6).
        L: Characteristic length, the largest |p_RT|, m.
        inverse, scratch: Places to work in (6, 6).

    Returns:
        A share up to 1; 0 where the pose is singular.
    """
    if not _invert_scaled(J, L, inverse, scratch):
        return 0.0
    shortest, b2, d2 = lengths[0], 0.0, 0.0
    for r in range(6):
        shortest = min(shortest, lengths[r])
        d = 0.0
        for c in range(6):
            b2 += inverse[c, r] * inverse[c, r]
            d += inverse[c, r] * (goal[c] - lengths[c])
        d2 += d * d
    b, d = np.sqrt(b2), np.sqrt(d2)
    if not d < 1e3:
        return 0.0
    # The ball's radius is 2 |d|; a leg shortens by sqrt(2) of it at most.
    # Where that is more than half of a leg, less of the way is looked at.
    share = 1.0 if d < 0.17 * shortest else 0.17 * shortest / d
    K2 = 0.0
    for r in range(6):
        nearest = lengths[r] - 2.83 * share * d
        K = 2.0 / nearest + 1.0 / L
        K2 += K * K
    admitted = b * np.sqrt(K2) * d
    return min(share, _ADMITTED / admitted) if admitted > 0.0 else share


@compiled_maker
def solve_stage_pose(goal, p_WB, p_RT, pose):
    """Finds the pose of a ring that has the given leg lengths.

    Args:
        goal: Leg lengths (6,), m.
        p_WB: Lower anchors in W (6, 3), m.
        p_RT: Upper anchors in the ring (6, 3), m.
        pose: q_WR, p_WR (7,): the start, and the result.

    Returns:
        Steps taken, one where the start is near; -1 where the way comes to a
        singularity, or does not end within MAX_STEPS; `pose` is then where it
        broke off.
    """
    R, lengths = np.empty((3, 3)), np.empty(6)
    J, inverse = np.empty((6, 6)), np.empty((6, 6))
    scratch, step_goal = np.empty((6, 6)), np.empty(6)
    L = 0.0
    for k in range(6):
        t = p_RT[k]
        L = max(L, np.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]))
    for taken in range(1, MAX_STEPS + 1):
        quaternion_to_matrix(pose[0:4], R)
        legs.calc_leg_kinematics(pose[4:7], R, p_WB, p_RT, lengths, J)
        share = admit_step(lengths, goal, J, L, inverse, scratch)
        if share <= 1e-6:
            return -1
        for k in range(6):
            step_goal[k] = lengths[k] + share * (goal[k] - lengths[k])
        if not legs.solve_forward_kinematics(
            step_goal, p_WB, p_RT, pose[4:7], pose[0:4]
        ):
            return -1
        if share == 1.0:
            return taken
    return -1


@compiled_law
def _carry_along(below, rest_below, rest, R, pose):
    """Puts a ring at its pose at rest relative to the ring below."""
    for c in range(4):
        pose[c] = below[c]
    for r in range(3):
        pose[4 + r] = below[4 + r]
        for c in range(3):
            pose[4 + r] += R[r, c] * (rest[c] - rest_below[c])


@compiled_maker
def solve_poses(goal, lower, upper, rest, from_rest, poses):
    """Finds the poses of all rings, from the lowest stage up.

    Args:
        goal: Leg lengths (6 S,), m.
        lower, upper: Anchors, see `stages.calc_kinematics`.
        rest: Positions of the rings at rest (S, 3), m.
        from_rest: Whether each stage starts at rest on the ring below, once
            this is found; else it starts from its pose in W as given.
        poses: q_WR, p_WR (S, 7): the start, near which a tick's search ends
            in one step, and the result.

    Returns:
        -1 where all were found, else the index of the stage that was not.
    """
    R, p_WB = np.empty((3, 3)), np.empty((6, 3))
    for i in range(poses.shape[0]):
        if i == 0:
            p_WB[:] = lower[0]
        else:
            quaternion_to_matrix(poses[i - 1, 0:4], R)
            place_lower_anchors(poses[i - 1], R, lower[i], p_WB)
            if from_rest:
                _carry_along(poses[i - 1], rest[i - 1], rest[i], R, poses[i])
        own = goal[6 * i : 6 * i + 6]
        if solve_stage_pose(own, p_WB, upper[i], poses[i]) < 0:
            return i
    return -1

"""Leg lengths, their Jacobians and inverse, and static leg forces."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import KinematicsError
from brace_drake.kinematics.geometry import BraceGeometry, check_vector
from brace_drake.laws import stage_poses, stages


def leg_lengths(geometry: BraceGeometry, X: np.ndarray) -> np.ndarray:
    """Leg lengths (6 S,), m, at task coordinates X (6 S,)."""
    return geometry.at(X)[0]


def leg_jacobian(geometry: BraceGeometry, X: np.ndarray) -> np.ndarray:
    """Jacobian J (6 S, 6 S) of the legs at X: l' = J V.

    V holds of each ring its velocity, then its angular velocity, in W; so
    leg forces f put J' f on the rings, forces and torques about Ro. J is
    block bidiagonal: a stage's legs move with the rings at both its ends.
    """
    _, J, J_L = geometry.at(X)
    n = geometry.num_stages
    whole = np.zeros((6 * n, 6 * n))
    for i in range(n):
        rows = slice(6 * i, 6 * i + 6)
        whole[rows, rows] = J[i]
        if i > 0:
            whole[rows, 6 * i - 6 : 6 * i] = J_L[i]
    return whole


def task_jacobian(geometry: BraceGeometry, X: np.ndarray) -> np.ndarray:
    """Derivative dl/dX (6 S, 6 S): l' = (dl/dX) X'.

    It differs from `leg_jacobian` by the rate of a rotation vector r not being
    the angular velocity: w = E(r) r'.
    """
    X = check_vector("X", X, 6 * geometry.num_stages)
    turn = np.eye(len(X))
    stages.turn_task_rates(X, turn, np.empty((3, 3)))
    return leg_jacobian(geometry, X) @ turn


def find_task_coordinates(
    geometry: BraceGeometry,
    lengths: np.ndarray,
    start: np.ndarray | None = None,
) -> np.ndarray:
    """Forward kinematics: X (6 S,) from leg lengths (6 S,), m.

    Each stage is followed from its start along the straight line of lengths
    by certified Newton steps (`brace_drake.laws.stage_poses`). What comes
    back is right: it has these lengths to 1e-10 m, and it is the pose that
    the mechanism goes to when its legs change so from the start, not another
    way of assembly. Where that way meets a singularity there is an error.
    In a set of lengths over which the stage has no singular pose, and that is
    convex as strokes are, every way ends: its pose is found from rest, and it
    is the only one.

    Args:
        geometry: Of the brace.
        lengths: Of all legs.
        start: Task coordinates to start from; without them, and stage by
            stage, the pose at rest on the ring below.

    Raises:
        KinematicsError: The way comes to a singularity: `lengths` are not
            those of a pose within the workspace.
    """
    n = geometry.num_stages
    goal = check_vector("lengths", lengths, 6 * n)
    poses, X = np.empty((n, 7)), np.empty(6 * n)
    origin = np.zeros(6 * n) if start is None else start
    origin = check_vector("start", origin, 6 * n)
    stages.place_rings(origin, geometry.rest, poses)
    solve, at = stage_poses.solve_poses, (geometry.lower, geometry.upper)
    failed = solve(goal, *at, geometry.rest, start is None, poses)
    if failed < 0:
        # From there once more: the error of the last step, squared.
        failed = solve(goal, *at, geometry.rest, False, poses)
    if failed >= 0:
        raise KinematicsError(
            f"no pose of stage {failed + 1} from below has the leg lengths"
            f" {goal[6 * failed : 6 * failed + 6].round(6).tolist()} m on this"
            " side of a singularity"
        )
    stages.calc_task_coordinates(poses, geometry.rest, X)
    return X


def static_leg_forces(
    geometry: BraceGeometry, X: np.ndarray, W: np.ndarray
) -> np.ndarray:
    """Leg forces J^-T W (6 S,), N, that hold the rings at X.

    Args:
        geometry: Of the brace.
        X: Task coordinates (6 S,).
        W: What the legs are to put on the rings (6 S,): force, then torque
            about Ro, in W; against gravity, for instance, m g on z.

    Raises:
        KinematicsError: A stage is singular at X.
    """
    _, J, J_L = geometry.at(X)
    W = check_vector("W", W, 6 * geometry.num_stages)
    f = np.empty_like(W)
    if not stages.solve_leg_forces(J, J_L, W, np.empty((6, 6)), f):
        raise KinematicsError("a stage is singular at X")
    return f


def holding_leg_forces(
    geometry: BraceGeometry, weights: np.ndarray
) -> np.ndarray:
    """Leg forces (6 S,), N, that carry the rings' weights (S,), N, at rest.

    Raises:
        KinematicsError: A stage is singular at rest.
    """
    W = np.zeros((geometry.num_stages, 6))
    W[:, 2] = weights
    return static_leg_forces(geometry, np.zeros(W.size), W.ravel())


def hold_at_rest(numbers) -> np.ndarray:
    """Forces of the legs, where the plant has them, at rest (n, 6), N.

    Args:
        numbers: See `laws.numbers`.
    """
    geometry = BraceGeometry(numbers.lower, numbers.upper, numbers.rest)
    return holding_leg_forces(geometry, numbers.ring[:, 4]).reshape(-1, 6)

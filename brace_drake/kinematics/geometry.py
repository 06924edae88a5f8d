"""Where the legs of a brace are joined to its rings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brace_drake.core.errors import KinematicsError
from brace_drake.laws import stages

# A leg shorter than this is no leg, m.
SHORTEST_LEG = 1e-3


@dataclass(frozen=True)
class BraceGeometry:
    """S stages: anchors of their legs, and the rings at rest.

    Attributes:
        lower: Lower anchors (S, 6, 3), m: of the lowest stage in W, of the
            others in the frame of the ring below.
        upper: Upper anchors in the frame of the ring above (S, 6, 3), m.
        rest: Positions of the moving rings in W at rest (S, 3), m; all rings
            are aligned with W.
    """

    lower: np.ndarray
    upper: np.ndarray
    rest: np.ndarray

    @property
    def num_stages(self) -> int:
        return len(self.rest)

    @cached_property
    def rest_lengths(self) -> np.ndarray:
        """Leg lengths at rest (6 S,), m."""
        return self.at(np.zeros(6 * self.num_stages))[0]

    def at(self, X: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Leg lengths (6 S,), m, J and J_L (S, 6, 6), see `laws.stages`.

        Raises:
            KinematicsError: X is not (6 S,) finite numbers.
        """
        X, n = check_vector("X", X, 6 * self.num_stages), self.num_stages
        poses, R = np.empty((n, 7)), np.empty((n, 3, 3))
        p_WB, lengths = np.empty((n, 6, 3)), np.empty(6 * n)
        J, J_L = np.empty((n, 6, 6)), np.zeros((n, 6, 6))
        stages.place_rings(X, self.rest, poses)
        stages.calc_kinematics(
            poses, self.lower, self.upper, R, p_WB, lengths, J, J_L
        )
        return lengths, J, J_L


def circle_points(
    radius: float, angles_deg: Sequence[float], height: float
) -> np.ndarray:
    """Points of a circle about z: angles from x towards y (n, 3), m."""
    angles = np.deg2rad(angles_deg)
    x, y = radius * np.cos(angles), radius * np.sin(angles)
    return np.column_stack([x, y, np.full_like(x, height)])


def make_geometry(
    lower: Sequence[tuple[float, Sequence[float]]],
    upper: Sequence[tuple[float, Sequence[float]]],
    heights: Sequence[float],
) -> BraceGeometry:
    """Geometry of stacked stages from their joint circles.

    Leg k of a stage joins angle k of its lower circle to angle k of its upper.

    Args:
        lower: Radius, m, and six angles, degrees, of each stage's lower
            circle, from the lowest stage up.
        upper: The same of the upper circles.
        heights: z of the rings in W at rest, m, the clamped one first (S + 1).

    Raises:
        KinematicsError: Sizes do not fit, a leg has no length, or a stage is
            singular at rest.
    """
    if not len(lower) == len(upper) == len(heights) - 1 > 0:
        raise KinematicsError(
            f"{len(lower)} lower circles, {len(upper)} upper circles and"
            f" {len(heights)} heights; allowed: S, S and S + 1 of them"
        )
    clamped = [heights[0]] + [0.0] * (len(lower) - 1)
    circles = [(*c, z) for c, z in zip(lower, clamped, strict=True)]
    lower_points = np.array([circle_points(*c) for c in circles])
    upper_points = np.array([circle_points(*c, 0.0) for c in upper])
    if not lower_points.shape == upper_points.shape == (len(lower), 6, 3):
        raise KinematicsError("a joint circle has not six angles")
    rest = np.array([[0.0, 0.0, z] for z in heights[1:]])
    geometry = BraceGeometry(lower_points, upper_points, rest)
    _check_rest(geometry)
    return geometry


def _check_rest(geometry: BraceGeometry) -> None:
    lengths, J, _ = geometry.at(np.zeros(6 * geometry.num_stages))
    for i in range(geometry.num_stages):
        own = lengths[6 * i : 6 * i + 6]
        # Not more than the shortest: NaN is none either.
        if not own.min() > SHORTEST_LEG:
            raise KinematicsError(
                f"leg {own.argmin() + 1} of stage {i + 1} from below is"
                f" {own.min():.3g} m long at rest; allowed: more than"
                f" {SHORTEST_LEG} m"
            )
        radius = np.linalg.norm(geometry.upper[i], axis=1).max()
        scaled = J[i] / np.array([1, 1, 1, radius, radius, radius])
        finite = np.isfinite(scaled).all()
        if not finite or np.linalg.svd(scaled, compute_uv=False)[-1] < 1e-6:
            raise KinematicsError(
                f"stage {i + 1} from below is singular at rest: its legs do"
                " not hold its ring"
            )


def check_vector(name: str, values: np.ndarray, size: int) -> np.ndarray:
    """The values as a vector of finite numbers.

    Raises:
        KinematicsError: They are not.
    """
    try:
        vector = np.ascontiguousarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise KinematicsError(f"{name} is not numbers: {error}") from error
    if vector.shape != (size,):
        raise KinematicsError(
            f"{name} has shape {vector.shape}; allowed: ({size},)"
        )
    if not np.isfinite(vector).all():
        raise KinematicsError(f"{name} has values that are not finite")
    return vector

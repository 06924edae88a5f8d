"""A torso's surface as a stack of closed cross-sections.

Frame T: origin at the centre of ring 2 at rest, x to the patient's front, y to
the left, z up. Section k is a horizontal outline, star-shaped about its centre:

    p_k(θ) = [cx_k + r_k(θ) cos θ, cy_k + r_k(θ) sin θ, z_k].

Between the sections the radius is linear in z, between the angles the outline
is straight. Measures and scans both become such a stack, dense enough that it
stands for the surface itself; solids and pads are made from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import brentq

# For the bend of a trunk: one standard deviation of smoothing, and what is
# left out at either end, m.
_SMOOTH, _END = 0.015, 0.08


@dataclass(frozen=True)
class Loft:
    """Sections of a torso in T.

    Attributes:
        heights: z of the sections, rising (n,), m.
        centres: x and y of their centres (n, 2), m.
        angles: θ from x towards y, rising within one turn (m,), rad.
        radii: From the centre to the surface (n, m), m.
    """

    heights: np.ndarray
    centres: np.ndarray
    angles: np.ndarray
    radii: np.ndarray

    @property
    def outlines(self) -> np.ndarray:
        """Points of the sections, shape (n, m, 3), m."""
        shape = self.radii.shape
        heights = np.broadcast_to(self.heights[:, None], shape)
        angles = np.broadcast_to(self.angles, shape)
        return loft_points(self, angles, heights)

    @property
    def axis(self) -> np.ndarray:
        """The centre line, shape (n, 3), m."""
        return np.column_stack([self.centres, self.heights])


def loft_points(loft: Loft, angles, heights) -> np.ndarray:
    """Points of the surface at angles about the centre line, (..., 3), m."""
    angles, heights = np.broadcast_arrays(angles, heights)
    radius = loft_radius(loft, angles, heights)[..., None]
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    across = loft_centre(loft, heights) + radius * ray
    return np.concatenate([across, heights[..., None]], axis=-1)


def loft_radius(loft: Loft, angles, heights) -> np.ndarray:
    """Radius of the surface about its centre line, m.

    Args:
        angles: θ about the centre at that height, rad, any shape.
        heights: z in T, m, of the same shape and within the loft.
    """
    k, w = _bracket(loft.heights, heights)
    turn = 2.0 * np.pi
    knots = np.append(loft.angles, loft.angles[0] + turn)
    angles = loft.angles[0] + np.mod(angles - loft.angles[0], turn)
    j = np.clip(np.searchsorted(knots, angles, "right") - 1, 0, len(knots) - 2)
    after = (j + 1) % len(loft.angles)
    a = (1 - w) * loft.radii[k, j] + w * loft.radii[k + 1, j]
    b = (1 - w) * loft.radii[k, after] + w * loft.radii[k + 1, after]
    # Where the ray meets the chord from a at knot j to b at the next one.
    past, left = angles - knots[j], knots[j + 1] - angles
    return a * b * np.sin(past + left) / (a * np.sin(past) + b * np.sin(left))


def loft_centre(loft: Loft, heights) -> np.ndarray:
    """Centres of the sections at given heights, shape (..., 2), m."""
    k, w = _bracket(loft.heights, heights)
    w = np.asarray(w)[..., None]
    return (1 - w) * loft.centres[k] + w * loft.centres[k + 1]


def _bracket(knots: np.ndarray, x) -> tuple[np.ndarray, np.ndarray]:
    """Interval of each x and its place in it, 0 to 1."""
    x = np.asarray(x, dtype=float)
    k = np.clip(np.searchsorted(knots, x, "right") - 1, 0, len(knots) - 2)
    return k, (x - knots[k]) / (knots[k + 1] - knots[k])


def side_angle(
    loft: Loft, height: float, side: float, point, across, distance: float
) -> float:
    """Angle at which the outline's side passes a distance along a direction.

    Args:
        height: z in T, m.
        side: +1 for the left (+y) half of the outline, -1 for the right.
        point, across: A horizontal line (2,) each: a point of it, m, and its
            unit direction, which must have a part towards the front.
        distance: From the point along the direction, m.

    Returns:
        θ about the section's centre, rad, in (-pi, pi).
    """
    start = loft_centre(loft, height) - point

    def missing(angle: float) -> float:
        """Grows along the side from back to front."""
        ray = np.array([np.cos(angle), np.sin(angle)])
        way = start + loft_radius(loft, angle, height) * ray
        return float(way @ across - distance)

    back, front = side * np.pi, 0.0
    if missing(back) >= 0.0:
        return back
    if missing(front) <= 0.0:
        return front
    return float(brentq(missing, back, front, xtol=1e-15))


def side_point(
    loft: Loft, height: float, side: float, x: float = 0.0
) -> np.ndarray:
    """Point of the side +1 (left, +y) or -1 at a height and an x (3,), m."""
    front = np.array([1.0, 0.0])
    angle = side_angle(loft, height, side, np.zeros(2), front, x)
    return loft_points(loft, angle, height)


def half_widths(loft: Loft, height: float) -> tuple[float, float]:
    """Distances along y from T's z-axis to the left and the right side, m."""
    left = side_point(loft, height, 1.0)[1]
    return float(left), float(-side_point(loft, height, -1.0)[1])


def measure_cobb(heights: np.ndarray, y: np.ndarray) -> float:
    """Cobb angle of a lateral centre line: between its most tilted tangents.

    Tangents are central differences.

    Args:
        heights: Rising, m. y: The line's lateral coordinate, m.

    Returns:
        deg.
    """
    tilt = np.arctan(np.gradient(y, heights))
    return float(np.rad2deg(tilt.max() - tilt.min()))


def measure_trunk_bend(loft: Loft) -> float:
    """Cobb angle of a torso's own centre line, deg.

    Of the trunk, which bends less than the spine in it: for comparing scans.
    Its sections' centres of area, smoothed over 3 cm against a scan's noise,
    between 8 cm above the lowest and 8 cm below the highest section.
    """
    step = loft.heights[1] - loft.heights[0]
    y = gaussian_filter1d(_area_centres_y(loft), _SMOOTH / step, mode="nearest")
    inner = (loft.heights > loft.heights[0] + _END) & (
        loft.heights < loft.heights[-1] - _END
    )
    return measure_cobb(loft.heights[inner], y[inner])


def _area_centres_y(loft: Loft) -> np.ndarray:
    a = loft.outlines[..., :2]
    b = np.roll(a, -1, axis=1)
    twice = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.sum(twice * (a + b)[..., 1], axis=1) / (3.0 * twice.sum(axis=1))

"""A torso from breadths, depths and heights, with a scoliotic curve.

The section at height z is a superellipse of breadth b(z), depth d(z) and
exponent e, turned by φ(z) about the vertical, around the point y(z):

    |2 x' / d|^e + |2 y' / b|^e = 1.

Breadth and depth between the levels that were measured are monotone cubics
(Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980): smooth, without overshoot.

The curve of scoliosis is one bend of the centre line, sideways only,

    y(z) = s A exp(-(z - a)^2 / (2 w^2)),  s = +1 convex to the left, -1 right,

whose most tilted vertebrae are the inflections z = a -+ w. Their tangents
enclose the Cobb angle (Cobb, AAOS Instr. Course Lect. 5, 1948)

    c = 2 atan(A e^(-1/2) / w),  thus  A = w e^(1/2) tan(c / 2).

The sections turn with the same bell, φ(z) = φ_a exp(-(z - a)^2 / (2 w^2)). In
a curve convex to the right the right side moves back (the rib hump): φ_a < 0.
In 101 patients a thoracic Cobb angle of 23.3 deg came with 4.5 deg of trunk
rotation, and 2 deg more with each further degree (BioMedical Engineering
OnLine 2017, doi 10.1186/s12938-017-0427-7).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from brace_drake.torso.loft import Loft
from brace_drake.torso.measures import Curve, TorsoMeasures

_SMOOTH = 0.015  # m, one standard deviation
_END = 0.08  # m


def bend(curve: Curve, height: np.ndarray) -> np.ndarray:
    """The bell of the curve, 1 at the apex."""
    return np.exp(-0.5 * ((np.asarray(height) - curve.apex) / curve.reach) ** 2)


def centre_line(curve: Curve, height: np.ndarray) -> np.ndarray:
    """y of the centre line in T, m, at heights in T, m."""
    tangent = np.tan(0.5 * np.deg2rad(curve.cobb_deg))
    side = 1.0 if curve.convex == "left" else -1.0
    return side * curve.reach * np.exp(0.5) * tangent * bend(curve, height)


def superellipse_radius(
    angle: np.ndarray, half_depth, half_breadth, exponent
) -> np.ndarray:
    """Radius of |x/a|^e + |y/b|^e = 1 at an angle from x towards y."""
    x = np.abs(np.cos(angle)) / half_depth
    y = np.abs(np.sin(angle)) / half_breadth
    return (x**exponent + y**exponent) ** (-1.0 / exponent)


def make_parametric_loft(
    measures: TorsoMeasures, sections: int = 161, around: int = 256
) -> Loft:
    """The torso of the measures as a dense stack of sections.

    With the default numbers its outlines lie within 0.03 mm of the surface.

    Args:
        sections: Between the lowest and the highest level.
        around: Points of each outline.
    """
    levels = np.asarray(measures.heights)
    heights = np.linspace(levels[0], levels[-1], sections)
    angles = np.arange(around) * (2.0 * np.pi / around)
    breadth = PchipInterpolator(levels, measures.breadths)(heights)
    depth = PchipInterpolator(levels, measures.depths)(heights)
    turn = np.deg2rad(measures.curve.axial_rotation_deg)
    turns = turn * bend(measures.curve, heights)
    radii = superellipse_radius(
        angles[None, :] - turns[:, None],
        0.5 * depth[:, None],
        0.5 * breadth[:, None],
        measures.exponent,
    )
    y = centre_line(measures.curve, heights)
    return Loft(heights, np.column_stack([np.zeros_like(y), y]), angles, radii)


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

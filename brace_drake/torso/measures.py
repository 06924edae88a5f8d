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

Sources of the defaults, which are the nominal torso of the bench (an adult, as
in the paper, at the ring heights of the data sheet):
[D] the data sheet: pads 0.15 m to either side of the ring's centre, iliac crest
    0.235 m below ring 2;
[ANS] ANSUR II, public data of 2012, adult men: chest 289 x 254 mm, waist
    326 x 238, hip 346 x 246, and of small women: iliac crest to C7 388 mm, to
    the trochanter 143 mm;
[A] assumed: the rest, between these.
`diagrams/torso_girl13.measures.yaml` holds those of small women, a proxy of a
girl of 13.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from brace_drake.core.errors import ScenarioError, TorsoError
from brace_drake.scenario.fields import fail
from brace_drake.scenario.load import LoadRecord
from brace_drake.torso.loft import Loft


def _vector(*values: float):
    return field(default_factory=lambda: np.array(values, dtype=float))


@dataclass
class Curve:
    """One bend of the centre line, in the frontal plane."""

    cobb_deg: float = 0.0
    apex: float = 0.0  # m, z in T of the apical vertebra
    reach: float = 0.07  # m, from the apex to either end vertebra
    convex: str = "right"  # or left
    axial_rotation_deg: float = 0.0  # at the apex, about z; > 0: left side back


@dataclass
class TorsoMeasures:
    """Breadths (y) and depths (x) at heights, from the lowest to the highest.

    Heights are z in T: 0 at ring 2, at the vertebra T7. The lowest and the
    highest are the ends of the trunk.
    """

    # m: trochanter, iliac crest, 10th rib, T11, T7, T4, shoulder, neck
    heights: np.ndarray = _vector(
        -0.378, -0.235, -0.175, -0.09, 0.0, 0.06, 0.11, 0.16
    )
    breadths: np.ndarray = _vector(
        0.346, 0.334, 0.32, 0.3, 0.3, 0.3, 0.29, 0.14
    )
    depths: np.ndarray = _vector(
        0.246, 0.24, 0.238, 0.242, 0.254, 0.254, 0.24, 0.13
    )
    exponent: float = 2.3  # of the section; 2 is an ellipse, more is boxier
    curve: Curve = field(default_factory=Curve)


def LoadMeasures(path: str | Path) -> TorsoMeasures:
    """Reads measures; what the file leaves out has the default.

    Raises:
        TorsoError: One line: file, key, value, what is allowed.
    """
    try:
        measures = LoadRecord(TorsoMeasures(), path)
        check_measures(measures, str(path))
    except ScenarioError as error:
        raise TorsoError(str(error)) from error
    return measures


# Key, least and largest value; those of a torso, and of scoliosis.
_RANGES = (
    ("heights", -0.6, 0.4),
    ("breadths", 0.05, 0.6),
    ("depths", 0.05, 0.5),
    ("exponent", 1.5, 5.0),
    ("curve.cobb_deg", 0.0, 100.0),
    ("curve.apex", -0.4, 0.3),
    ("curve.reach", 0.03, 0.2),
    ("curve.axial_rotation_deg", -45.0, 45.0),
)


def check_measures(measures: TorsoMeasures, source: str) -> None:
    """Checks every number of the measures.

    Raises:
        ScenarioError: One line: source, key, value, what is allowed.
    """
    levels = len(measures.heights)
    if levels < 2 or np.any(np.diff(measures.heights) < 0.01):
        allowed = "two or more, each at least 0.01 m above the last"
        fail(source, "heights", measures.heights, allowed)
    for key in ("breadths", "depths"):
        if len(getattr(measures, key)) != levels:
            allowed = f"{levels} numbers, one for each of heights"
            fail(source, key, getattr(measures, key), allowed)
    for key, low, high in _RANGES:
        value = measures
        for name in key.split("."):
            value = getattr(value, name)
        # Written so that NaN fails.
        if not np.all((np.asarray(value) >= low) & (np.asarray(value) <= high)):
            fail(source, key, value, f"{low:g} to {high:g}")
    if measures.curve.convex not in ("left", "right"):
        fail(source, "curve.convex", measures.curve.convex, "left or right")


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

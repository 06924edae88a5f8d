"""What is measured of a torso, as a file holds it: heights, widths, the curve.

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

from brace_drake.core.errors import ScenarioError, TorsoError
from brace_drake.scenario.load import LoadRecord
from brace_drake.scenario.messages import fail


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

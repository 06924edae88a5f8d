"""What only makes sense together in a scenario of the whole brace."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import KinematicsError
from brace_drake.kinematics import BraceGeometry
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import (
    pack_brace,
    pack_geometry,
    pack_rings,
)
from brace_drake.scenario.check_controllers import check_control
from brace_drake.scenario.messages import fail


def check_brace(source: str, scenario: BraceScenario) -> None:
    """Checks stages, geometry, strokes, poses at the start, and control.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    _check_stages(source, scenario)
    try:
        geometry = pack_geometry(scenario)
    except KinematicsError as error:
        fail(source, "joints", _radii(scenario), f"legs that reach: {error}")
    _check_strokes(source, scenario, geometry)
    _check_start(source, scenario)
    check_control(scenario.control, pack_rings(scenario), source, "control")


def _check_stages(source: str, scenario: BraceScenario) -> None:
    stages, heights = scenario.stages, scenario.ring_heights
    first = stages[0] if stages else 0
    if not stages or stages != list(range(first, first + len(stages))):
        fail(source, "stages", stages, "neighbours, from the lowest up")
    if first < 1 or stages[-1] > 3:
        fail(source, "stages", stages, "of 1, 2, 3")
    if not (np.diff(heights) > 0.0).all():
        fail(source, "ring_heights", heights, "each above the one before")


def _radii(scenario: BraceScenario) -> list[list[float]]:
    stages = [getattr(scenario.joints, f"stage{i}") for i in scenario.stages]
    return [[s.lower.radius, s.upper.radius] for s in stages]


def _check_strokes(
    source: str, scenario: BraceScenario, geometry: BraceGeometry
) -> None:
    """The stroke, centred on the rest, has to leave a closed leg a length.

    A rod inside its tube lengthens a leg to no more than twice its closed
    length.
    """
    stroke = scenario.leg.stroke
    shortest = geometry.rest_lengths.min()
    most = 2.0 / 3.0 * shortest
    if not stroke < most:
        fail(
            source,
            "leg.stroke",
            stroke,
            f"less than {most:.4g} m: the shortest leg is {shortest:.4g} m at"
            " rest, and open no longer than twice its closed length",
        )


def _check_start(source: str, scenario: BraceScenario) -> None:
    numbers = pack_brace(scenario)
    geometry, X = numbers.geometry, numbers.start
    for i, name in enumerate(scenario.rings):
        try:
            numbers.workspace.check_stage(geometry, X, i)
        except KinematicsError as error:
            own = X[6 * i : 6 * i + 6]
            fail(source, f"start.{name}", own, f"a pose in reach: {error}")

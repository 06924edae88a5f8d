"""What only makes sense together in a scenario of the whole brace."""

from __future__ import annotations

import numpy as np

from brace_drake.errors import KinematicsError
from brace_drake.kinematics import BraceGeometry
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_geometry
from brace_drake.scenario.messages import fail, suggest


def check_brace(source: str, scenario: BraceScenario) -> None:
    """Checks stages, geometry, strokes and poses at the start.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    _check_stages(source, scenario)
    _check_controller(source, scenario)
    try:
        geometry = pack_geometry(scenario)
    except KinematicsError as error:
        fail(source, "joints", _radii(scenario), f"legs that reach: {error}")
    _check_strokes(source, scenario, geometry)
    _check_start(source, scenario)


def _check_stages(source: str, scenario: BraceScenario) -> None:
    stages, heights = scenario.stages, scenario.ring_heights
    first = stages[0] if stages else 0
    if not stages or stages != list(range(first, first + len(stages))):
        fail(source, "stages", stages, "neighbours, from the lowest up")
    if first < 1 or stages[-1] > 3:
        fail(source, "stages", stages, "of 1, 2, 3")
    if not (np.diff(heights) > 0.0).all():
        fail(source, "ring_heights", heights, "each above the one before")


def _check_controller(source: str, scenario: BraceScenario) -> None:
    control = scenario.control
    if control.controller not in control.controllers:
        words = ", ".join(control.controllers) or "none is given"
        hint = suggest(control.controller, control.controllers)
        allowed = f"a tag of control.controllers: {words}{hint}"
        fail(source, "control.controller", control.controller, allowed)
    for tag, numbers in control.controllers.items():
        for name, values in numbers.items():
            if len(values) == 0:
                path = f"control.controllers.{tag}.{name}"
                fail(source, path, values, "one number or more")


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

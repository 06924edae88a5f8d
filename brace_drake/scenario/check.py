"""What only makes sense together in a scenario; limits stand at the fields."""

from __future__ import annotations

import math

import numpy as np

from brace_drake.core.errors import KinematicsError
from brace_drake.recording.columns import BENCH
from brace_drake.scenario.brace import BraceScenario, Contact
from brace_drake.scenario.brace_numbers import (
    pack_geometry,
    pack_rings,
    pack_start,
    pack_workspace,
)
from brace_drake.scenario.effects import check_effects
from brace_drake.scenario.fields import check_fields, fail
from brace_drake.scenario.stability import check_control

_MOST_POINTS = 10  # of a pad, in a row
_MOST_STEPS = 1000  # of the plant in a control period


def CheckScenario(scenario, source: str = "scenario") -> None:
    """Checks every value of a scenario.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    check_fields(scenario, source, num_rings=_num_rings(scenario))
    check_effects(source, scenario)
    if hasattr(scenario, "control"):
        period = 1.0 / scenario.control.rate
        _check_period(source, "time_step", scenario.time_step, period)
    if isinstance(scenario, BraceScenario):
        _check_bodies(source, scenario)
        _check_stages(source, scenario)
        _check_geometry(source, scenario)
        control, rings = scenario.control, pack_rings(scenario)
        check_control(control, rings, source, "control")


def _num_rings(scenario) -> int:
    stages = getattr(scenario, "stages", None)
    return len(stages) if isinstance(stages, list) else 1


def _check_period(source: str, path: str, value: float, period: float) -> None:
    if not _is_whole(period / value) or period / value > _MOST_STEPS:
        allowed = (
            f"a whole part of the control period, {period:g} s, and no less"
            f" than {1e6 * period / _MOST_STEPS:g} us"
        )
        fail(source, path, value, allowed)


def _is_whole(ratio: float) -> bool:
    """Whether a ratio is 1, 2, 3 ..., rounding aside."""
    return 0.5 <= ratio < math.inf and abs(ratio - round(ratio)) <= 1e-6


def _check_bodies(source: str, scenario: BraceScenario) -> None:
    """Checks moments of inertia, pads, and the period of the log."""
    for path, body in (("ring", scenario.ring), ("torso", scenario.torso)):
        moments = np.sort(body.inertia)
        if moments[2] > moments[0] + moments[1]:
            allowed = "no moment above the others' sum"
            fail(source, f"{path}.inertia", body.inertia, allowed)
    for name in ("ring1", "ring2", "ring3"):
        contact = getattr(scenario.contact, name)
        _check_contact(source, f"contact.{name}", contact)
    period, log = 1.0 / scenario.control.rate, scenario.sensors.log_period
    if not _is_whole(log / period):
        allowed = f"a multiple of the control period, {period:g} s"
        fail(source, "sensors.log_period", log, allowed)


def _check_contact(source: str, path: str, contact: Contact) -> None:
    points = contact.pad_points
    within = all(0 <= n <= _MOST_POINTS for n in points)
    if len(points) != 2 or not within or (0 in points and any(points)):
        allowed = f"two whole numbers of 1 to {_MOST_POINTS}, or 0, 0"
        fail(source, f"{path}.pad_points", points, allowed)
    if contact.preload >= contact.pad_offset:
        allowed = f"less than {path}.pad_offset, {contact.pad_offset}"
        fail(source, f"{path}.preload", contact.preload, allowed)


def _check_stages(source: str, scenario: BraceScenario) -> None:
    stages, heights = scenario.stages, scenario.ring_heights
    first = stages[0] if stages else 0
    if not stages or stages != list(range(first, first + len(stages))):
        fail(source, "stages", stages, "neighbours, from the lowest up")
    if first < 1 or stages[-1] > 3:
        fail(source, "stages", stages, "of 1, 2, 3")
    if scenario.device == BENCH and stages != [2]:
        fail(source, "stages", stages, f"[2], as the device is {BENCH}")
    if scenario.device == BENCH and scenario.control.tag != "pic":
        # The compiled twin of the bench has no other; a brace has them all.
        fail(source, "control.tag", scenario.control.tag, "pic on the bench")
    if not (np.diff(heights) > 0.0).all():
        fail(source, "ring_heights", heights, "each above the one before")


def _check_geometry(source: str, scenario: BraceScenario) -> None:
    """Checks anchors, strokes, and poses at the start.

    The stroke, centred on the rest, has to leave a closed leg a length: a rod
    inside its tube lengthens a leg to no more than twice its closed length.
    """
    try:
        geometry = pack_geometry(scenario)
    except KinematicsError as error:
        stages = [
            getattr(scenario.joints, f"stage{i}") for i in scenario.stages
        ]
        radii = [[s.lower.radius, s.upper.radius] for s in stages]
        fail(source, "joints", radii, f"legs that reach: {error}")
    stroke, shortest = scenario.leg.stroke, geometry.rest_lengths.min()
    most = 2.0 / 3.0 * shortest
    if not stroke < most:
        fail(
            source,
            "leg.stroke",
            stroke,
            f"less than {most:.4g} m: the shortest leg is {shortest:.4g} m at"
            " rest, and open no longer than twice its closed length",
        )
    X, workspace = pack_start(scenario), pack_workspace(scenario)
    for i, name in enumerate(scenario.rings):
        try:
            workspace.check_stage(geometry, X, i)
        except KinematicsError as error:
            own = X[6 * i : 6 * i + 6]
            fail(source, f"start.{name}", own, f"a pose in reach: {error}")

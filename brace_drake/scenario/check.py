"""What a scenario may hold: kinds, ranges, and how values fit together."""

from __future__ import annotations

import math
import re

import numpy as np

from brace_drake.scenario.bench import BenchScenario, Contact
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.check_brace import check_brace
from brace_drake.scenario.effects import check_effects
from brace_drake.scenario.leaves import check_kind, walk
from brace_drake.scenario.messages import fail

_POSITIVE = (
    "time_step ring.mass ring.inertia leg.force_limit torso.mass torso.inertia"
    " stage.lower.radius stage.upper.radius contact.stiffness"
    " contact.friction_regularization contact.pad_offset contact.pad_size"
    " contact.hydroelastic_modulus contact.hydroelastic_thickness control.rate"
    " control.kp control.velocity_cutoff_hz control.force_filter_tau"
    " control.desired_mass control.desired_stiffness control.desired_damping"
    " sensors.log_period mass control.force_limit stiffness depth_scale"
    " rate_scale joints.lower.radius joints.upper.radius ring.half_axes"
    " leg.stroke leg.tube_mass leg.rod_mass leg.tube_radius leg.rod_radius"
    " workspace.singular_value"
).split()
_NOT_NEGATIVE = (
    "gravity leg.viscous torso.posture_stiffness torso.posture_damping"
    " torso.posture_rot_stiffness torso.posture_rot_damping contact.damping"
    " contact.friction contact.preload contact.hydroelastic_dissipation"
    " control.kd control.kv sensors.leg_length_noise"
    " sensors.leg_length_resolution sensors.force_noise"
    " sensors.force_resolution sensors.marker_noise viscous position_noise"
    " damping force_noise displacement_noise"
).split()
_WORDS = {
    "contact.model": ("linear", "hydroelastic"),
    "contact.ring.model": ("none", "linear", "hydroelastic"),
    "mechanism": ("task_space", "articulated"),
}
_MOST_POINTS = 10  # of a pad, in a row
# What holds of one ring or stage holds of each.
_ONE_OF_MANY = re.compile(r"\.(ring|stage)[1-3]")


def CheckScenario(scenario, source: str = "scenario") -> None:
    """Checks every value of a scenario.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    defaults = dict(walk(type(scenario)()))
    values = dict(walk(scenario))
    is_brace, rate = isinstance(scenario, BraceScenario), "control.rate"
    for path, value in values.items():
        # A brace's controller may have a number for each ring: check_control.
        free = is_brace and path.startswith("control.") and path != rate
        default = value if free else defaults.get(path, value)
        check_kind(source, path, value, default)
        rule = _ONE_OF_MANY.sub("", path)
        if rule in _POSITIVE and not np.all(np.asarray(value) > 0.0):
            fail(source, path, value, "greater than 0")
        if rule in _NOT_NEGATIVE and not np.all(np.asarray(value) >= 0.0):
            fail(source, path, value, "0 or more")
        words = _WORDS.get(_ONE_OF_MANY.sub(r".\1", path), (value,))
        if value not in words:
            fail(source, path, value, " or ".join(words))
    if rate in values:
        _check_period(source, values, "time_step", 1.0 / values[rate])
    if is_brace:
        _check_parts(source, scenario)
        for name, contact in vars(scenario.contact).items():
            _check_contact(source, f"contact.{name}", contact)
        check_brace(source, scenario)
        return
    check_effects(source, scenario.effects, scenario.device)
    if isinstance(scenario, BenchScenario):
        _check_bench(source, scenario)


def _check_bench(source: str, scenario: BenchScenario) -> None:
    """Checks what only makes sense together."""
    stage, contact = scenario.stage, scenario.contact
    if not stage.upper_height > stage.lower_height:
        path = "stage.upper_height"
        fail(
            source,
            path,
            stage.upper_height,
            f"more than stage.lower_height, {stage.lower_height}",
        )
    _check_parts(source, scenario)
    _check_contact(source, "contact", contact)


def _check_parts(source: str, scenario: BenchScenario | BraceScenario) -> None:
    """Checks moments of inertia, and the period of the log."""
    for path, body in (("ring", scenario.ring), ("torso", scenario.torso)):
        moments = np.sort(body.inertia)
        if moments[2] > moments[0] + moments[1]:
            allowed = "no moment above the others' sum"
            fail(source, f"{path}.inertia", body.inertia, allowed)
    period = 1.0 / scenario.control.rate
    ratio = scenario.sensors.log_period / period
    whole = math.isfinite(ratio) and abs(ratio - round(ratio)) <= 1e-6
    if ratio < 0.5 or not whole:
        fail(
            source,
            "sensors.log_period",
            scenario.sensors.log_period,
            f"a multiple of the control period, {period:g} s",
        )


def _check_contact(source: str, path: str, contact: Contact) -> None:
    points = contact.pad_points
    whole = all(type(n) is int and 0 <= n <= _MOST_POINTS for n in points)
    if len(points) != 2 or not whole or (0 in points and any(points)):
        allowed = f"two whole numbers of 1 to {_MOST_POINTS}, or 0, 0"
        fail(source, f"{path}.pad_points", points, allowed)
    if contact.preload >= contact.pad_offset:
        fail(
            source,
            f"{path}.preload",
            contact.preload,
            f"less than {path}.pad_offset, {contact.pad_offset}",
        )


def _check_period(source: str, values: dict, path: str, period: float) -> None:
    ratio = period / values[path]
    whole = math.isfinite(ratio) and abs(ratio - round(ratio)) <= 1e-6
    if ratio < 0.5 or not whole:
        fail(
            source,
            path,
            values[path],
            f"a whole part of the control period, {period:g} s",
        )

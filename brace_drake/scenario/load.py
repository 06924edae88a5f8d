"""Scenario files: read, checked, and written."""

from __future__ import annotations

import copy
import re
from dataclasses import fields
from pathlib import Path

from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import OutputError, ScenarioError
from brace_drake.core.output import WriteText
from brace_drake.core.reading import LoadYaml, in_file, parse_yaml
from brace_drake.recording.columns import (
    AXIS,
    BENCH,
    BRACE,
    DIAGRAM,
    LEG_BENCH,
    PAD_BENCH,
)
from brace_drake.scenario.axis import AxisScenario
from brace_drake.scenario.brace import BenchScenario, BraceScenario, Contact
from brace_drake.scenario.check import CheckScenario
from brace_drake.scenario.diagram import DiagramScenario
from brace_drake.scenario.fields import fail, merge
from brace_drake.scenario.leg_bench import LegBenchScenario
from brace_drake.scenario.pad_bench import PadBenchScenario
from brace_drake.scenario.tolerances import Tolerances, split_tolerances

# Block of a file that says what a fit moves, see `devices.choice`.
ESTIMATION = "estimation"
# The device that a file names decides what it may hold.
SCHEMAS = {
    BENCH: BenchScenario,
    LEG_BENCH: LegBenchScenario,
    PAD_BENCH: PadBenchScenario,
    AXIS: AxisScenario,
    DIAGRAM: DiagramScenario,
    BRACE: BraceScenario,
}

# Keys that a bench had before it was a brace of which one stage moves.
_MOVED = {
    "stage": "joints.stage2 and ring_heights",
    "control.kp": "control.inner.kp",
    "control.kd": "control.inner.kd",
    "control.velocity_cutoff_hz": "control.estimation.velocity_cutoff_hz",
    "control.force_filter_tau": "control.estimation.force_filter_tau",
    "control.desired_mass": "control.impedance.mass",
    "control.desired_stiffness": "control.impedance.stiffness",
    "control.desired_damping": "control.impedance.damping_ratio",
    **{f"contact.{f.name}": f"contact.ring2.{f.name}" for f in fields(Contact)},
}

Scenario = BraceScenario | LegBenchScenario | PadBenchScenario


def LoadScenario(path: str | Path, overrides: str | None = None) -> Scenario:
    """Reads a scenario file, then YAML text over it, and checks the result.

    Args:
        path: A `.scenario.yaml` file; what it leaves out has the default, but
            a file without anything was hardly meant.
        overrides: YAML text, for instance "torso: {mass: 30.0}"; maps are
            merged into those of the file, lists and arrays replace.

    Where neither says a word on tolerances, those of the scenario are the
    defaults and not stated.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    data = LoadYaml(path, ScenarioError)
    return make_scenario(data, str(path), overrides)


def make_scenario(
    data: dict, source: str, overrides: str | None = None
) -> Scenario:
    """A scenario from the map that a file holds, see `LoadScenario`.

    The block `estimation` is left alone: it is of a fit, not of a machine.

    Args:
        data: As YAML has it.
        source: The file, for errors.
        overrides: YAML text over it.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    path, data = source, {k: v for k, v in data.items() if k != ESTIMATION}
    if "format" in data:
        kind = " ".join(repr(data["format"]).split())
        raise ScenarioError(f"{path}: this is {kind:.60}, not a scenario")
    device = data.get("device", BENCH)
    if not isinstance(device, str) or device not in SCHEMAS:
        fail(source, "device", device, f"one of {', '.join(SCHEMAS)}")
    scenario = SCHEMAS[device]()
    if isinstance(scenario, BraceScenario):
        scenario.tolerances.is_stated = False
    _merge(scenario, data, source)
    if overrides:
        source = f"{path} with overrides"
        with in_file(source, ScenarioError):
            data = parse_yaml(overrides, may_be_empty=True)
        _merge(scenario, data, source)
    CheckScenario(scenario, source)
    return scenario


def LoadRecord(defaults, path: str | Path):
    """Reads a YAML file over a dataclass's defaults; only kinds are checked.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    record = copy.deepcopy(defaults)
    data = LoadYaml(path, ScenarioError, may_be_empty=True)
    merge(record, data, str(path))
    return record


def SaveScenario(scenario: Scenario, path: str | Path) -> None:
    """Writes a checked scenario; the file appears complete or not at all.

    Raises:
        ScenarioError: A value is not allowed, or the file cannot be written.
    """
    path = Path(path)
    CheckScenario(scenario, str(path))
    try:
        WriteText(path, scenario_text(scenario))
    except OutputError as error:
        raise ScenarioError(str(error)) from error


def _merge(scenario: Scenario, data: dict, source: str) -> None:
    """Lays a file over a scenario; keys of old files are told their place."""
    for old, new in _MOVED.items() if hasattr(scenario, "stages") else ():
        part, _, key = old.partition(".")
        own = data.get(part)
        there = not key or (isinstance(own, dict) and key in own)
        if part in data and there:
            raise ScenarioError(f"{source}: {old}: no such key; it is {new}")
    data, tolerances = split_tolerances(scenario, data, source)
    merge(scenario, data, source)
    if tolerances is not None:
        scenario.tolerances = tolerances


def scenario_text(scenario: Scenario) -> str:
    """A scenario as the YAML of its file; tolerances that are assumed are not
    stated.
    """
    text = yaml_dump_typed(scenario)
    own = getattr(scenario, "tolerances", None)
    if own is None or own.is_stated or own != Tolerances():
        return text
    return re.sub(r"^tolerances:\n(?: .*\n)+", "", text, flags=re.MULTILINE)

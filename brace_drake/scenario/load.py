"""Scenario files: read, checked, and written."""

from __future__ import annotations

import dataclasses
import typing
from pathlib import Path

import numpy as np
import yaml
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from brace_drake.core.errors import OutputError, ScenarioError, reason, suggest
from brace_drake.core.output import WriteText
from brace_drake.scenario.bench import DEVICE, BenchScenario
from brace_drake.scenario.brace import DEVICE as BRACE_DEVICE
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.check import CheckScenario
from brace_drake.scenario.leg_bench import DEVICE as LEG_DEVICE
from brace_drake.scenario.leg_bench import LegBenchScenario
from brace_drake.scenario.messages import fail
from brace_drake.scenario.pad_bench import DEVICE as PAD_DEVICE
from brace_drake.scenario.pad_bench import PadBenchScenario

# The device that a file names decides what it may hold.
SCHEMAS = {
    DEVICE: BenchScenario,
    LEG_DEVICE: LegBenchScenario,
    PAD_DEVICE: PadBenchScenario,
    BRACE_DEVICE: BraceScenario,
}

Scenario = BenchScenario | LegBenchScenario | PadBenchScenario | BraceScenario


def LoadScenario(path: str | Path, overrides: str | None = None) -> Scenario:
    """Reads a scenario file, then YAML text over it, and checks the result.

    Args:
        path: A `.scenario.yaml` file; what it leaves out has the default.
        overrides: YAML text, for instance "torso: {mass: 30.0}"; maps are
            merged into those of the file, lists and arrays replace.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    path = Path(path)
    text = _read(path)
    data = _parse(text, str(path))
    if "format" in data:
        kind = " ".join(repr(data["format"]).split())
        raise ScenarioError(f"{path}: this is {kind:.60}, not a scenario")
    device = data.get("device", DEVICE)
    if not isinstance(device, str) or device not in SCHEMAS:
        fail(str(path), "device", device, f"one of {', '.join(SCHEMAS)}")
    scenario = _load(SCHEMAS[device](), text, data, str(path))
    source = str(path)
    if overrides:
        source = f"{path} with overrides"
        data = _parse(overrides, source)
        scenario = _load(scenario, overrides, data, source)
    CheckScenario(scenario, source)
    return scenario


def LoadRecord(defaults, path: str | Path):
    """Reads a YAML file over a dataclass's defaults; only kinds are checked.

    Raises:
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    text = _read(Path(path))
    return _load(defaults, text, _parse(text, str(path)), str(path))


def SaveScenario(scenario: Scenario, path: str | Path) -> None:
    """Writes a checked scenario; the file appears complete or not at all.

    Raises:
        ScenarioError: A value is not allowed, or the file cannot be written.
    """
    path = Path(path)
    CheckScenario(scenario, str(path))
    try:
        WriteText(path, yaml_dump_typed(scenario))
    except OutputError as error:
        raise ScenarioError(str(error)) from error


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(
            f"{path}: cannot be read: {reason(error)}"
        ) from error


def _parse(text: str, source: str) -> dict:
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        line = " ".join(str(error).split())
        raise ScenarioError(f"{source}: not YAML: {line}") from error
    if data is None:
        return {}
    if not isinstance(data, dict):
        fail(source, "the whole text", data, "a map of keys")
    return data


def _load(defaults, text: str, data: dict, source: str):
    # Drake names neither file nor key where a value does not convert.
    _check_map(type(defaults), data, source, "")
    try:
        return yaml_load_typed(
            schema=type(defaults),
            data=text,
            defaults=defaults,
            retain_map_defaults=True,
        )
    except (RuntimeError, ValueError, TypeError) as error:
        line = " ".join(str(error).split())
        raise ScenarioError(f"{source}: {line}") from error


def _check_map(schema: type, data, source: str, at: str) -> None:
    """Checks keys and kinds of values of a map against a dataclass."""
    if not isinstance(data, dict):
        fail(source, at, data, "a map of keys")
    hints = typing.get_type_hints(schema)
    for key, value in data.items():
        path = f"{at}.{key}" if at else str(key)
        if key not in hints:
            path = path if path.isprintable() else repr(path)
            hint = suggest(key, hints)
            raise ScenarioError(f"{source}: {path}: no such key{hint}")
        _check_value(hints[key], value, source, path)


def _check_value(kind, value, source: str, path: str) -> None:
    origin = typing.get_origin(kind)
    if dataclasses.is_dataclass(kind):
        _check_map(kind, value, source, path)
    elif kind is np.ndarray or origin is list:
        if not isinstance(value, list):
            fail(source, path, value, "a list")
        (item,) = typing.get_args(kind) or (float,)
        for i, entry in enumerate(value):
            _check_value(item, entry, source, f"{path}[{i}]")
    elif origin is dict:
        if not isinstance(value, dict):
            fail(source, path, value, "a map of keys")
        for key, entry in value.items():
            inner = typing.get_args(kind)[1]
            _check_value(inner, entry, source, f"{path}.{key}")
    elif kind is float and not _is_number(value):
        fail(source, path, value, "a number")
    elif kind is int and type(value) is not int:
        fail(source, path, value, "a whole number")
    elif kind is bool and not isinstance(value, bool):
        fail(source, path, value, "true or false")
    elif kind is str and not isinstance(value, str):
        fail(source, path, value, "a word")


def _is_number(value) -> bool:
    if isinstance(value, bool):
        return False
    try:
        float(value)
    except (TypeError, ValueError):
        return False
    return True

"""A campaign from files and a map that says which column is which channel."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import CampaignError, reason, suggest
from brace_drake.recording.columns import DEVICES
from brace_drake.recording.importing.options import (
    check_options,
    check_rate,
    check_run,
)
from brace_drake.recording.importing.tables import Columns, LoadTable
from brace_drake.recording.recording import Campaign, Run

FORMAT = "brace-import/1"
_KEYS = (
    "format",
    "device",
    "subject",
    "columns",
    "runs",
    "options",
    "rate_hz",
    "settled_s",
)
_RUN_KEYS = ("file", "contact", "motion", "repeat_of", "split", "name")
_RULE_KEYS = ("from", "scale", "offset", "constant")
_LEAST_RATE_DEVIATION = 0.02


def ImportCampaign(path: str | Path) -> Campaign:
    """Reads a map and all files that it names.

    The map is YAML: `format: brace-import/1`, `device`, `subject`, `columns`
    (channel: name of the file's column, or {from, scale, offset}, or
    {constant}), `runs` (items of campaign.yaml, with the foreign `file`),
    `options` for the reader, `rate_hz` where the files are to be resampled, and
    `settled_s`, how long the first reference had been held before each run.

    Raises:
        CampaignError: One line: file, key or column, and what is allowed.
    """
    path = Path(path)
    content = _LoadMap(path)
    device = content.get("device")
    if not isinstance(device, str) or device not in DEVICES:
        raise CampaignError(
            f"{path}: device is {device!r}; allowed: {', '.join(DEVICES)}"
        )
    columns = content.get("columns") or {}
    if not isinstance(columns, dict):
        raise CampaignError(f"{path}: columns must be a map of channels")
    rules = {
        name: _parse_rule(path, name, rule, device)
        for name, rule in columns.items()
    }
    needed = [c.name for c in DEVICES[device].values() if c.required]
    missing = [name for name in needed if name not in rules]
    if missing:
        raise CampaignError(f"{path}: columns has no {', '.join(missing)}")
    options = check_options(str(path), content.get("options") or {})
    rate = check_rate(str(path), content.get("rate_hz"))
    settled = content.get("settled_s", 0.0)
    if type(settled) not in (int, float) or not 0.0 <= settled < math.inf:
        raise CampaignError(
            f"{path}: settled_s is {settled!r}; allowed: a number from 0"
        )
    runs = [
        replace(
            _ImportRun(path, item, rules, options, rate),
            settled_s=float(settled),
        )
        for item in _list_runs(path, content)
    ]
    steps = np.diff(runs[0].time_s)
    found = 1.0 / float(np.median(steps))
    subject = str(content.get("subject") or "")
    return Campaign(path, device, float(rate or found), subject, tuple(runs))


def _LoadMap(path: Path) -> dict:
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise CampaignError(
            f"{path}: cannot be read: {reason(error)}"
        ) from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise CampaignError(f"{path}: format must be {FORMAT!r}")
    _check_keys(path, "", content, _KEYS)
    return content


def _check_keys(path: Path, place: str, item: dict, allowed) -> None:
    for key in item:
        if key not in allowed:
            hint = suggest(key, allowed)
            raise CampaignError(f"{path}: {place}no key {key!r}{hint}")


def _list_runs(path: Path, content: dict) -> list[dict]:
    runs = content.get("runs")
    if not isinstance(runs, list) or not runs:
        raise CampaignError(f"{path}: runs must be a list of runs")
    for number, run in enumerate(runs, 1):
        check_run(str(path), number, run)
        _check_keys(path, f"run {number}: ", run, _RUN_KEYS)
    return runs


def _parse_rule(path: Path, name: str, rule, device: str) -> dict:
    if name not in DEVICES[device]:
        hint = suggest(name, DEVICES[device])
        raise CampaignError(f"{path}: no channel {name!r}{hint}")
    if isinstance(rule, str):
        rule = {"from": rule}
    if not isinstance(rule, dict) or ("from" in rule) == ("constant" in rule):
        raise CampaignError(
            f"{path}: columns.{name} must be a column's name, or from (with"
            " scale, offset), or constant"
        )
    _check_keys(path, f"columns.{name}: ", rule, _RULE_KEYS)
    if not isinstance(rule.get("from", ""), str):
        raise CampaignError(
            f"{path}: columns.{name}.from is {rule['from']!r}; allowed: a name"
        )
    for key in ("scale", "offset", "constant"):
        value = rule.get(key, 1.0)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise CampaignError(
                f"{path}: columns.{name}.{key} is {value!r}; allowed: a number"
            )
    return rule


def _ImportRun(path, item, rules, options, rate) -> Run:
    source = path.parent / item["file"]
    table = LoadTable(source, options)
    rows = len(next(iter(table.values())))
    channels = {
        name: _channel(source, table, rule, rows)
        for name, rule in rules.items()
    }
    lengths = {len(values) for values in channels.values()}
    if len(lengths) > 1:
        raise CampaignError(
            f"{source}: the columns differ in length: {sorted(lengths)}"
        )
    (samples,) = lengths
    if samples < 2:
        raise CampaignError(
            f"{source}: it has {samples} samples; allowed: two or more"
        )
    channels["time_s"] = channels["time_s"] - channels["time_s"][0]
    if rate is not None:
        channels = _resample(source, channels, float(rate))
    name = item.get("name") or Path(item["file"]).stem
    return Run(
        f"{name}.csv",
        bool(item.get("contact", True)),
        str(item.get("motion", name)),
        item.get("repeat_of"),
        str(item.get("split", "fit")),
        channels,
    )


def _channel(source: Path, table: Columns, rule: dict, rows: int):
    if "constant" in rule:
        return np.full(rows, float(rule["constant"]))
    name = rule["from"]
    if name not in table:
        hint = suggest(name, table)
        raise CampaignError(f"{source}: no column {name!r}{hint}")
    scale, offset = rule.get("scale", 1.0), rule.get("offset", 0.0)
    return scale * table[name] + offset


def _resample(source: Path, channels: Columns, rate: float) -> Columns:
    """Channels at even times, linearly between their samples."""
    time = channels["time_s"]
    steps = np.diff(time)
    if not (len(time) > 1 and np.isfinite(time).all() and steps.min() > 0.0):
        raise CampaignError(f"{source}: the time does not increase")
    if np.abs(steps * rate - 1.0).max() < _LEAST_RATE_DEVIATION:
        return channels
    if 1.0 / np.median(steps) < 0.9 * rate:
        raise CampaignError(
            f"{source}: sampled at {1.0 / np.median(steps):.4g} Hz, which"
            f" cannot be made {rate:g} Hz"
        )
    even = np.arange(int(time[-1] * rate + 1e-6) + 1) / rate
    out = {n: np.interp(even, time, values) for n, values in channels.items()}
    return {**out, "time_s": even}

"""A campaign from files and a map that says which column is which channel."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError, quoted, suggest
from brace_drake.core.reading import LoadYaml
from brace_drake.recording.columns import DEVICES
from brace_drake.recording.fields import (
    DURATION,
    HUGE,
    RATE,
    SWITCH,
    TEXT,
    Field,
    number_from,
    take,
)
from brace_drake.recording.importing.tables import OPTIONS, LoadTable
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.table import Columns

FORMAT = "brace-import/1"
_LEAST_RATE_DEVIATION = 0.02

_HEAD = {
    "format": Field(repr(FORMAT), lambda v: v == FORMAT),
    "device": Field(
        ", ".join(DEVICES), lambda v: isinstance(v, str) and v in DEVICES
    ),
    "columns": Field("a map of channels", lambda v: isinstance(v, dict)),
    "runs": Field("a list of runs", lambda v: isinstance(v, list) and v != []),
    "options": Field(
        "a map of names", lambda v: isinstance(v, dict), required=False
    ),
    "rate_hz": RATE._replace(required=False),
    "settled_s": DURATION,
    "subject": Field(
        "text", lambda v: isinstance(v, str | int | float), required=False
    ),
}
_RUN = {
    "file": TEXT._replace(required=True),
    "contact": SWITCH,
    **dict.fromkeys(("motion", "repeat_of", "split", "name"), TEXT),
}
_NUMBER = number_from(-HUGE, HUGE, required=False)
_RULE = {"from": TEXT, "scale": _NUMBER, "offset": _NUMBER, "constant": _NUMBER}


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
    head = _take(LoadYaml(path, CampaignError), _HEAD, f"{path}: ")
    channels = DEVICES[head["device"]].channels
    rules = {
        name: _parse_rule(path, name, rule)
        for name, rule in head["columns"].items()
    }
    for name in rules:
        if name not in channels:
            hint = suggest(name, channels)
            raise CampaignError(f"{path}: no channel {quoted(name)}{hint}")
    missing = [n for n, c in channels.items() if c.required and n not in rules]
    if missing:
        raise CampaignError(f"{path}: columns has no {', '.join(missing)}")
    options = _take(head.get("options", {}), OPTIONS, f"{path}: options.")
    items = [
        _take(item, _RUN, f"{path}: run {number}: ")
        for number, item in enumerate(head["runs"], 1)
    ]
    _name_runs(path, items)
    rate = head.get("rate_hz")
    settled = float(head.get("settled_s", 0.0))
    runs = []
    for item in items:
        source = path.parent / item["file"]
        columns = _read_channels(source, rules, LoadTable(source, options))
        if rate is not None:
            columns = _resample(source, columns, float(rate))
        runs.append(_make_run(item, columns, settled))
    found = 1.0 / float(np.median(np.diff(runs[0].time_s)))
    subject = str(head.get("subject") or "")
    return Campaign(
        path, head["device"], float(rate or found), subject, tuple(runs)
    )


def _take(values: object, fields: Mapping[str, Field], place: str) -> dict:
    """The declared fields of a mapping; refuses any other, and bad values."""
    if not isinstance(values, dict):
        raise CampaignError(
            f"{place}is {quoted(values)}; allowed: a map of names"
        )
    for key in values:
        if key not in fields:
            hint = suggest(key, fields) or f"; allowed: {', '.join(fields)}"
            raise CampaignError(f"{place}no key {quoted(key)}{hint}")
    taken, faults = take(values, fields)
    for name, wanted, value in faults:
        raise CampaignError(
            f"{place}{name} is {quoted(value)}; allowed: {wanted}"
        )
    return taken


def _parse_rule(path: Path, name: str, rule: object) -> dict:
    """Where a channel's values come from; see `ImportCampaign`."""
    if isinstance(rule, str):
        rule = {"from": rule}
    place = f"{path}: columns.{name}"
    taken = _take(rule, _RULE, f"{place}.") if isinstance(rule, dict) else {}
    if ("from" in taken) == ("constant" in taken):
        raise CampaignError(
            f"{place} must be a column's name, or from (with scale, offset),"
            " or constant"
        )
    return taken


def _read_channels(
    source: Path, rules: dict[str, dict], table: Columns
) -> Columns:
    """Channels of a file by their rules, the time from 0."""
    rows = len(next(iter(table.values())))
    channels = {}
    for name, rule in rules.items():
        column = rule.get("from")
        if column is None:
            channels[name] = np.full(rows, float(rule["constant"]))
        elif column not in table:
            hint = suggest(column, table)
            raise CampaignError(f"{source}: no column {quoted(column)}{hint}")
        else:
            scale, offset = rule.get("scale", 1.0), rule.get("offset", 0.0)
            with np.errstate(over="ignore", invalid="ignore"):
                channels[name] = scale * table[column] + offset
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
    for name, values in channels.items():
        bad = ~(np.abs(values) <= HUGE)
        if name != "time_s":
            bad &= ~np.isnan(values)
        _refuse_rows(source, name, values, bad, f"numbers up to {HUGE:g}")
    time = channels["time_s"] - channels["time_s"][0]
    falls = np.diff(time, prepend=-1.0) < 1.0 / HUGE
    _refuse_rows(
        source, "time_s", channels["time_s"], falls, "more than before"
    )
    channels["time_s"] = time
    return channels


def _refuse_rows(
    source: Path, name: str, values: np.ndarray, bad: np.ndarray, allowed: str
) -> None:
    if bad.any():
        row = int(np.argmax(bad))
        raise CampaignError(
            f"{source}: row {row + 1}: {name} is {values[row]:g}; allowed:"
            f" {allowed}"
        )


def _name_runs(path: Path, items: list[dict]) -> None:
    """Gives each run its name; `repeat_of` may be that, or a foreign file.

    Raises:
        CampaignError: Runs share a name, or a repeat repeats no run.
    """
    files: dict[str, str] = {}
    for number, item in enumerate(items, 1):
        name = item.setdefault("name", Path(item["file"]).stem)
        if name in files:
            raise CampaignError(
                f"{path}: run {number}: {quoted(name)} is another run's name"
                " already; give it one of its own by `name`"
            )
        files[name] = f"{name}.csv"
    for item in items:
        files.setdefault(item["file"], f"{item['name']}.csv")
        files.setdefault(f"{item['name']}.csv", f"{item['name']}.csv")
    for number, item in enumerate(items, 1):
        repeated = item.get("repeat_of")
        if repeated is None:
            continue
        if files.get(repeated, f"{item['name']}.csv") == f"{item['name']}.csv":
            raise CampaignError(
                f"{path}: run {number}: repeat_of is {quoted(repeated)};"
                f" allowed: another run{suggest(repeated, files)}"
            )
        item["repeat_of"] = files[repeated]


def _make_run(item: dict, channels: Columns, settled_s: float) -> Run:
    name = item["name"]
    return Run(
        file=f"{name}.csv",
        contact=item.get("contact", True),
        motion=item.get("motion", name),
        repeat_of=item.get("repeat_of"),
        split=item.get("split", "fit"),
        channels=channels,
        settled_s=settled_s,
    )


def _resample(source: Path, channels: Columns, rate: float) -> Columns:
    """Channels at even times, linearly between their samples."""
    time = channels["time_s"]
    steps = np.diff(time)
    if np.abs(steps * rate - 1.0).max() < _LEAST_RATE_DEVIATION:
        return channels
    if 1.0 / np.median(steps) < 0.9 * rate:
        raise CampaignError(
            f"{source}: sampled at {1.0 / np.median(steps):.4g} Hz, which"
            f" cannot be made {rate:g} Hz"
        )
    samples = int(time[-1] * rate + 1e-6) + 1
    if samples > 10 * len(time):
        raise CampaignError(
            f"{source}: {len(time)} samples over {time[-1]:g} s cannot be made"
            f" {samples}: the time jumps"
        )
    even = np.arange(samples) / rate
    out = {n: np.interp(even, time, values) for n, values in channels.items()}
    return {**out, "time_s": even}

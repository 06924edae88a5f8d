"""Rules of a map: from a file's columns to a device's channels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError, quoted, suggest
from brace_drake.recording.fields import HUGE, TEXT, Field, number_from, take
from brace_drake.recording.findings import counted
from brace_drake.recording.importing.formats.cells import ALLOWED, Table
from brace_drake.recording.importing.units import scale_of
from brace_drake.recording.read import LEAST_ROWS
from brace_drake.recording.samples import since_first_row, without_rounding
from brace_drake.recording.table import Columns

_LEAST_RATE_DEVIATION = 0.02
MOST_ADDED = 64  # columns
_NUMBER = number_from(-HUGE, HUGE, required=False)
_FACTOR = number_from(-HUGE, HUGE)
_RULE = {
    "from": Field(
        "a column's name, or a map of columns to their factors",
        lambda v: (
            isinstance(v, str | int | dict)
            and v not in ("", {})
            and not (isinstance(v, dict) and len(v) > MOST_ADDED)
        ),
        required=False,
    ),
    "unit": TEXT,
    **dict.fromkeys(("scale", "offset", "constant"), _NUMBER),
}


def take_map(values: object, fields: Mapping[str, Field], place: str) -> dict:
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


def parse_rule(path: Path, name: str, rule: object) -> dict:
    """Where a channel's values come from; see `ImportCampaign`."""
    if isinstance(rule, str | int) and not isinstance(rule, bool):
        rule = {"from": rule}
    place = f"{path}: columns.{name}"
    taken = take_map(rule, _RULE, f"{place}.") if isinstance(rule, dict) else {}
    if "from" in taken:
        taken["from"] = _parse_sum(f"{place}.from", taken["from"])
    if ("from" in taken) == ("constant" in taken):
        raise CampaignError(
            f"{place} must be a column's name, or from (with scale, offset),"
            " or constant"
        )
    if "unit" in taken:
        scale = scale_of(taken["unit"], name)
        if isinstance(scale, str):
            unit = quoted(taken["unit"])
            raise CampaignError(f"{place}.unit is {unit}; allowed: {scale}")
        taken["scale"] = scale * taken.get("scale", 1.0)
    return taken


def _parse_sum(place: str, source: object) -> dict[str, float]:
    """Columns and the factors by which they are added up."""
    if not isinstance(source, dict):
        return {str(source): 1.0}
    fields = dict.fromkeys(source, _FACTOR)
    taken = take_map(source, fields, f"{place}.")
    return {str(column): float(factor) for column, factor in taken.items()}


def check_columns(
    source: Path | str, table: Table, names: Iterable[str]
) -> None:
    """Columns are there, and hold numbers alone.

    Raises:
        CampaignError: One line: file, row, column, and what is allowed.
    """
    for name in names:
        if name in table.words:
            row, holds = table.words[name]
            raise CampaignError(
                f"{source}: row {row}: column {quoted(name)} is {holds};"
                f" allowed: {ALLOWED}"
            )
        if name not in table:
            there = quoted(list(table))[1:-1]
            hint = f"; there are {there}; {table.advice}"
            hint = suggest(name, table) or hint
            raise CampaignError(f"{source}: no column {quoted(name)}{hint}")


def check_rows(source: Path | str, rows: int) -> None:
    """There are as many rows as a run needs.

    Raises:
        CampaignError: One line: file, rows, and what is allowed.
    """
    if rows < LEAST_ROWS:
        raise CampaignError(
            f"{source}: it has {counted(rows, 'row')}; allowed:"
            f" {LEAST_ROWS} or more"
        )


def _add_up(
    source: Path, table: Table, factors: dict[str, float]
) -> np.ndarray:
    check_columns(source, table, factors)
    lengths = {len(table[column]) for column in factors}
    if len(lengths) > 1:
        raise CampaignError(
            f"{source}: {', '.join(map(quoted, factors))} differ in length:"
            f" {sorted(lengths)}"
        )
    parts = (factor * table[c] for c, factor in factors.items())
    total = next(parts)
    for part in parts:
        total += part
    return total


def read_channels(
    source: Path, rules: dict[str, dict], table: Table
) -> Columns:
    """Channels of a file by their rules, the time from 0."""
    rows = len(next(iter(table.values())))
    channels = {}
    for name, rule in rules.items():
        scale, offset = rule.get("scale", 1.0), rule.get("offset", 0.0)
        if "from" not in rule:
            value = scale * float(rule["constant"]) + offset
            channels[name] = np.full(rows, value)
            continue
        with np.errstate(over="ignore", invalid="ignore"):
            values = _add_up(source, table, rule["from"])
            # In their place: a long recording has no room for copies.
            values *= scale
            values += offset
            channels[name] = values
    lengths = {len(values) for values in channels.values()}
    if len(lengths) > 1:
        raise CampaignError(
            f"{source}: the columns differ in length: {sorted(lengths)}"
        )
    (samples,) = lengths
    check_rows(source, samples)
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
    channels["time_s"] = since_first_row(without_rounding(time))
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


def rows_at(rate: float, duration: float) -> int:
    """Rows that a run of a duration, s, has at a rate, Hz."""
    return int(duration * rate + 1e-6) + 1


def resample(source: Path, channels: Columns, rate: float) -> Columns:
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
    samples = rows_at(rate, time[-1])
    if samples < LEAST_ROWS:
        raise CampaignError(
            f"{source}: {time[-1]:g} s at {rate:g} Hz (rate_hz) are"
            f" {counted(samples, 'row')}; allowed: {LEAST_ROWS} or more"
        )
    if samples > 10 * len(time):
        raise CampaignError(
            f"{source}: {len(time)} samples over {time[-1]:g} s cannot be made"
            f" {samples}: the time jumps"
        )
    even = np.arange(samples) / rate
    out = {n: np.interp(even, time, values) for n, values in channels.items()}
    return {**out, "time_s": even}

"""A draft of a map: which column of a file may be which channel.

Columns are guessed from their names, units and ranges; whoever knows the
machine has the last word.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

import numpy as np

from brace_drake.recording.columns import (
    AXIS,
    DEVICES,
    shown_unit,
    split_unit,
)
from brace_drake.recording.importing.derived import derivable
from brace_drake.recording.importing.dialect import guess_options
from brace_drake.recording.importing.stage_names import (
    guess_stage_channels,
    words_of,
)
from brace_drake.recording.importing.tables import LoadTable
from brace_drake.recording.importing.units import is_unit
from brace_drake.recording.table import Columns

# Of a remark.
_WIDTH = 76
# A step in time of so much is one of milliseconds.
_SLOWEST_S = 0.9
# Spellings of units in headers, as `units` has them.
_UNITS = {
    "sec": "s", "seconds": "s", "msec": "ms", "millimeter": "mm",
    "degree": "deg", "degrees": "deg", "nm": "N m", "n·m": "N m", "nmm": "N mm",
    "°": "deg", "n": "N", "kn": "kN", "µm": "um", "m/s²": "m/s^2",
    "n.m": "N m", "n*m": "N m", "mnm": "mN m", "mn·m": "mN m", "ncm": "N cm",
    "knm": "kN m", "°/s": "deg/s", "1/min": "rpm", "μm": "um", "μs": "us",
    "µs": "us",
}  # fmt: skip
_COMMAND = (
    r"\b(c|cmd|command|commanded|ref|reference|set|setpoint|target|desired"
    r"|goal|demand|demanded|wanted|consigne|soll\w*)\b"
)
# Units at the end of a name that no channel of an axis has.
_OTHER = re.compile(
    r"([_(\[](m?A|[mk]?V|k?W|bar|[kM]?Pa|°?C|K|Hz|%)"
    r"|\s(mA|[mk]V|kW|bar|[kM]?Pa|°C|Hz))[)\]]?\s*$"
)
_POSITIONS = ("position_m", "position_rad")
# Of the first of two encoders.
_MOTOR = r"\b(motor|input shaft|drive side)\b"
# Words of a name, and the channels of an axis that it may be, by their units.
_WORDS = (
    (r"\b(t|(time)?stamp|time|epoch|elapsed|zeit|clock|temps)\b", ("time_s",)),
    (
        r"\b(torque|moment|drehmoment|tau|m)\b",
        ("torque_N_m", "torque_command_N_m"),
    ),
    (r"\b(force|load|kraft|f)\b", ("force_N", "force_command_N")),
    (
        r"\b(speed|velocity|vel|v|omega|qd|geschwindigkeit)\b",
        ("speed_m_s", "speed_command_m_s"),
    ),
    (
        r"\b(angle|phi|theta|q|winkel|rotation)\b",
        ("position_rad", "position_command_rad"),
    ),
    (
        r"\b(position|pos|displacement|disp|stroke|travel|way|(soll|ist)?weg"
        r"|x|y|extension)\b",
        ("position_m", "position_command_m"),
    ),
)
# One of each kind of unit.
_CHANNELS = (
    *("time_s", "position_m", "position_rad", "speed_m_s"),
    *("speed_rad_s", "force_N", "torque_N_m"),
)
_ROTARY = {
    "motor_position_m": "motor_position_rad",
    "position_m": "position_rad",
    "position_command_m": "position_command_rad",
    "speed_m_s": "speed_rad_s",
    "speed_command_m_s": "speed_command_rad_s",
}


@dataclass(frozen=True)
class Guess:
    """What a column may be.

    Attributes:
        column: Its name in the file.
        unit: As its name has it; empty without one.
        channel: Of an axis; None where nothing fits.
        low, high: Its range.
        by_range: Whether the unit is guessed from it.
    """

    column: str
    unit: str
    channel: str | None
    low: float
    high: float
    by_range: bool = False


class Draft(NamedTuple):
    """A recording, and what it was taken for.

    Attributes:
        path: The file.
        options: Of its reader.
        table: Its columns.
        device: Whose recording it may be.
        guesses: What each column may be.
    """

    path: Path
    options: dict
    table: Columns
    device: str
    guesses: list[Guess]


def read_draft(path: str | Path) -> Draft:
    """A file, its columns, and what they may be.

    Raises:
        CampaignError: The file cannot be read, or has no columns of numbers.
    """
    options = guess_options(Path(path))
    table = LoadTable(path, options)
    return Draft(Path(path), options, table, *guess_channels(table))


def draft_map(draft: Draft) -> str:
    """A map for one file, as YAML with what was guessed in remarks."""
    return "\n".join(_lines(draft)) + "\n"


def guess_channels(table: Columns) -> tuple[str, list[Guess]]:
    """The device, and what each column may be; a channel is given once.

    A column whose name says no unit has that in which its range is plausible.
    """
    device, known = guess_stage_channels(table) or (AXIS, _by_column(table))
    found = []
    for column, values in table.items():
        unit, channel = unit_of(column), known.get(column)
        finite = values[np.isfinite(values)]
        low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 0.0)
        guessed = ""
        if channel is not None and not unit:
            guessed = _unit_by_range(device, channel, finite)
        ends = float(low), float(high)
        found.append(
            Guess(column, unit or guessed, channel, *ends, bool(guessed))
        )
    return device, found


def _unit_by_range(device: str, channel: str, values: np.ndarray) -> str:
    """A thousandth of the channel's unit where only that is plausible."""
    if channel == "time_s":
        steps = np.diff(values)
        step = float(np.median(steps)) if len(steps) else 0.0
        is_us = step < 1e6 or 1e14 < np.abs(values).max() < 1e16
        larger = "ms" if step < 1e3 else "us" if is_us else "ns"
        return "" if step < _SLOWEST_S else larger
    known = DEVICES[device].channels[channel]
    largest = np.abs(values).max(initial=0.0)
    limit = max(abs(known.low), abs(known.high))
    if not limit < largest <= 1e3 * limit:
        return ""
    return {"m": "mm", "m_s": "mm/s", "m_s2": "mm/s^2"}.get(known.unit, "")


def unit_of(column: str) -> str:
    """The unit in a column's name: in brackets, or its last part."""
    bracketed = re.search(r"[\[(]([^\])]*)[\])]\s*$", column)
    own = split_unit(column)[1]
    if own and not bracketed:
        # As our own columns have it.
        return shown_unit(own)
    text = bracketed[1] if bracketed else re.split(r"[\s_,;]+", column)[-1]
    text = text.strip()
    known = _UNITS.get(text.lower(), text)
    fits = any(is_unit(known, c) for c in _CHANNELS)
    return known if fits and (bracketed or known != column) else ""


def _by_column(table: Columns) -> dict[str, str]:
    """Channels of an axis by column: by its words first, where those say
    nothing by its unit.
    """
    found: dict[str, str] = {}
    for by_unit in (False, True):
        for column in table:
            if column not in found:
                every = _channels(column, unit_of(column), by_unit)
                free = [c for c in every if c not in found.values()]
                if free:
                    found[column] = free[0]
    if not {*_POSITIONS} & {*found.values()}:
        # The only encoder may be the motor's.
        found = {c: n.removeprefix("motor_") for c, n in found.items()}
    return found


def _channels(column: str, unit: str, by_unit: bool) -> Iterator[str]:
    """Channels that a column may be, by a word of its name or by its unit."""
    if _OTHER.search(column):
        return
    if column in DEVICES[AXIS].channels:
        yield column
    words = words_of(column)
    is_command = bool(re.search(_COMMAND, words))
    for pattern, (measured, *command) in _WORDS:
        if not (unit if by_unit else re.search(pattern, words)):
            continue
        channel = command[0] if is_command and command else measured
        if channel in _POSITIONS and re.search(_MOTOR, words):
            channel = "motor_position_m"
        for name in (channel, _ROTARY.get(channel)):
            if name is not None and (not unit or is_unit(unit, name)):
                yield name


def _lines(draft: Draft) -> Iterator[str]:
    path, options, table, device, guesses = draft
    yield "format: brace-import/1"
    yield f"device: {device}  # or another one: brace-drake devices"
    yield f"subject: {_quoted(path.stem)}"
    yield "columns:"
    for g in guesses:
        if g.channel is not None:
            source = _quoted(g.column)
            rule = f"{{from: {source}, unit: {g.unit}}}" if g.unit else source
            guess = ", unit by its range?" if g.by_range else ""
            yield f"  {g.channel}: {rule}  # {g.low:.4g} to {g.high:.4g}{guess}"
    for g in guesses:
        if g.channel is None:
            name = re.sub(r"\W+", "_", g.column).strip("_") or "x"
            name = name.removeprefix("input_")
            as_input = f"input_{name}" if device == AXIS else "CHANNEL"
            yield (
                f"  # {as_input}: {_quoted(g.column)}"
                f"  # {g.low:.4g} to {g.high:.4g}: not used as it stands"
            )
    yield from _open_channels(device, {g.channel for g in guesses})
    if options:
        pairs = ", ".join(f"{k}: {_quoted(v)}" for k, v in options.items())
        yield f"options: {{{pairs}}}"
    yield f"# {len(next(iter(table.values())))} rows"
    yield "runs:"
    yield "# Paths count from this map; names of motions: brace-drake motions."
    if device != AXIS:
        yield "# Where the ring met nothing: contact: false."
    motion, file = "stroke" if device == AXIS else "push", path.as_posix()
    yield f"- {{file: {_quoted(file)}, motion: {motion}, split: fit}}"
    yield "# one run or more of another motion, to test what was found:"
    yield "# - {file: other.csv, motion: other, split: validation}"


def _open_channels(device: str, known: set) -> Iterator[str]:
    """A remark for each channel that is needed and was not found."""
    if "time_s" not in known:
        yield "  # time_s: which column is the time?"
    channels = DEVICES[device].channels
    follows = derivable(channels, filter(None, known))
    for name, channel in channels.items():
        is_open = name not in known and name not in follows
        if channel.required and is_open and name != "time_s":
            yield f"  # {name}: which column is it? It is needed."
    others = [
        name
        for name, channel in channels.items()
        if not (channel.required or name in known or name in follows)
    ]
    if others and device != AXIS:
        text = "not found; without them less can be told apart: "
        text += ", ".join(others)
        for line in wrap(text, _WIDTH):
            yield f"  # {line}"


def _quoted(value) -> str:
    """As YAML, on one line and without what a terminal obeys."""
    if isinstance(value, int):
        return str(value)
    return json.dumps(value)

"""A draft of a map: which column of a file may be which channel.

Columns are guessed from their names and units alone; whoever knows the machine
has the last word.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.core.reading import ReadBytes, in_file
from brace_drake.core.reading.rows import decode_lines
from brace_drake.recording.columns import AXIS, shown_unit, split_unit
from brace_drake.recording.importing.tables import LoadTable
from brace_drake.recording.importing.units import scale_of
from brace_drake.recording.table import Columns

_SEPARATORS = (";", "\t", ",", "|")
_LINES, _PREAMBLE = 60, 40
_NUMBER = re.compile(r"[-+]?\d+([.,]\d+)?([eE][-+]?\d+)?")
# Spellings of units in headers, as `units` has them.
_UNITS = {
    "sec": "s", "seconds": "s", "msec": "ms", "millimeter": "mm",
    "degree": "deg", "degrees": "deg", "nm": "N m", "n·m": "N m", "nmm": "N mm",
    "°": "deg", "n": "N", "kn": "kN", "µm": "um", "m/s²": "m/s^2",
}  # fmt: skip
_COMMAND = (
    r"\b(c|cmd|command|commanded|ref|reference|set|setpoint|target|desired)\b"
)
# Words of a name, and the channels of an axis that it may be, by their units.
_WORDS = (
    (r"\b(t|time|timestamp|zeit|clock|temps)\b", ("time_s",)),
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
        r"\b(position|pos|displacement|disp|stroke|travel|way|weg|x|y|extension)\b",
        ("position_m", "position_command_m"),
    ),
)
# One of each kind of unit.
_CHANNELS = (
    *("time_s", "position_m", "position_rad", "speed_m_s"),
    *("speed_rad_s", "force_N", "torque_N_m"),
)
_ROTARY = {
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
    """

    column: str
    unit: str
    channel: str | None
    low: float
    high: float


def draft_map(path: str | Path) -> str:
    """A map for one file, as YAML with what was guessed in remarks.

    Raises:
        CampaignError: The file cannot be read, or has no columns of numbers.
    """
    path = Path(path)
    options = guess_options(path)
    table = LoadTable(path, options)
    return "\n".join(_lines(path, options, guess_channels(table), table)) + "\n"


def guess_options(path: Path) -> dict:
    """Separator, decimal sign and lines before the header of a text file."""
    if path.suffix.lower() not in (".csv", ".txt", ".tsv"):
        return {}
    with in_file(path, CampaignError):
        lines = decode_lines(ReadBytes(path)).split("\n")[:_LINES]
    best: tuple[int, str, int] = (0, ",", 0)
    for separator in _SEPARATORS:
        widths = [line.count(separator) for line in lines if line.strip()]
        width = max(set(widths), key=widths.count, default=0)
        count = widths.count(width)
        skipped = next(
            (
                i
                for i, line in enumerate(lines)
                if line.count(separator) == width
            ),
            0,
        )
        # Commas beside another separator are decimal signs.
        if width and count > best[0]:
            best = (count, separator, skipped)
    _, separator, skipped = best
    options: dict[str, str | int] = {}
    if separator != ("\t" if path.suffix.lower() == ".tsv" else ","):
        options["delimiter"] = separator
    fields = [f.strip() for f in "".join(lines[-5:]).split(separator)]
    if separator != "," and any(
        re.fullmatch(r"[-+]?\d+,\d+", f) for f in fields
    ):
        options["decimal"] = ","
    if 0 < skipped <= _PREAMBLE:
        options["skip_lines"] = skipped
    return options


def guess_channels(table: Columns) -> list[Guess]:
    """What each column may be; each channel is given once, the first time is
    the time.
    """
    taken: set[str] = set()
    found = []
    for column, values in table.items():
        unit = unit_of(column)
        channel = next(
            (c for c in _channels(column, unit) if c not in taken), None
        )
        if channel is not None:
            taken.add(channel)
        finite = values[np.isfinite(values)]
        low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 0.0)
        found.append(Guess(column, unit, channel, float(low), float(high)))
    return found


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
    is_unit = any(isinstance(scale_of(known, c), float) for c in _CHANNELS)
    return known if is_unit and (bracketed or known != column) else ""


def _channels(column: str, unit: str) -> Iterator[str]:
    words = re.sub(r"[\[(].*", "", column)
    words = re.sub(r"(?<=[a-z])(?=[A-Z])|[_\-.]", " ", words).lower()
    is_command = bool(re.search(_COMMAND, words))
    for pattern, (measured, *command) in _WORDS:
        if not re.search(pattern, words):
            continue
        channel = command[0] if is_command and command else measured
        for name in (channel, _ROTARY.get(channel)):
            fits = not unit or (
                name is not None and isinstance(scale_of(unit, name), float)
            )
            if name is not None and fits:
                yield name


def _lines(
    path: Path, options: dict, guesses: list[Guess], table: Columns
) -> Iterator[str]:
    yield "format: brace-import/1"
    yield f"device: {AXIS}  # or another one: brace-drake import --help"
    yield f"subject: {_quoted(path.stem)}"
    yield "columns:"
    for g in guesses:
        if g.channel is not None:
            source = _quoted(g.column)
            rule = f"{{from: {source}, unit: {g.unit}}}" if g.unit else source
            yield f"  {g.channel}: {rule}  # {g.low:.4g} to {g.high:.4g}"
    for g in guesses:
        if g.channel is None:
            name = re.sub(r"\W+", "_", g.column).strip("_") or "x"
            name = name.removeprefix("input_")
            yield (
                f"  # input_{name}: {_quoted(g.column)}"
                f"  # {g.low:.4g} to {g.high:.4g}: measured beside it?"
            )
    if "time_s" not in {g.channel for g in guesses}:
        yield "  # time_s: which column is the time?"
    if options:
        pairs = ", ".join(f"{k}: {_quoted(v)}" for k, v in options.items())
        yield f"options: {{{pairs}}}"
    yield f"# {len(next(iter(table.values())))} rows"
    yield "runs:"
    yield f"- {{file: {_quoted(path.name)}, motion: stroke, split: fit}}"
    yield "# one run or more of another motion, to test what was found:"
    yield "# - {file: other.csv, motion: other, split: validation}"


def _quoted(value) -> str:
    if isinstance(value, int):
        return str(value)
    text = value.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\t")
    return f'"{text}"'

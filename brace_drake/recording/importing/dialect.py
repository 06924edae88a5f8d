"""How a text file writes its table: separator, decimal sign, preamble."""

from __future__ import annotations

import re
from pathlib import Path

from brace_drake.core.errors import CampaignError
from brace_drake.core.reading import in_file
from brace_drake.recording.importing.formats.text import BLANKS, read_lines

_SEPARATORS = (";", "\t", ",", "|")
_ENDINGS = (".csv", ".txt", ".tsv", ".dat")
_LINES, _PREAMBLE = 60, 40
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")


def guess_options(path: Path) -> dict[str, str | int]:
    """Options for the reader of a file, empty where they are the usual ones.

    Raises:
        CampaignError: The file cannot be read.
    """
    if path.suffix.lower() not in _ENDINGS:
        return {}
    with in_file(path, CampaignError):
        lines = read_lines(path)[:_LINES]
    separator, skipped = _separator(lines)
    options: dict[str, str | int] = {}
    if separator != ("\t" if path.suffix.lower() == ".tsv" else ","):
        options["delimiter"] = separator
    last = " ".join(lines[-5:])
    fields = last.split() if separator == BLANKS else last.split(separator)
    if separator != "," and any(
        _DECIMAL_COMMA.fullmatch(field.strip()) for field in fields
    ):
        options["decimal"] = ","
    if 0 < skipped <= _PREAMBLE:
        options["skip_lines"] = skipped
    return options


def _separator(lines: list[str]) -> tuple[str, int]:
    """What parts most lines alike, and how many come before the first of them.

    Commas beside another separator are decimal signs; blanks count where
    nothing else parts.
    """
    best: tuple[int, str, int] = (0, ",", 0)
    for separator in (*_SEPARATORS, BLANKS):
        widths = [_count(line, separator) for line in lines]
        told = [w for w in widths if w > 0]
        width = max(set(told), key=told.count, default=0)
        count = told.count(width)
        is_first = separator != BLANKS or best[0] < len(told) / 2
        if count > best[0] and is_first:
            best = (count, separator, widths.index(width))
    return best[1:]


def _count(line: str, separator: str) -> int:
    if separator == BLANKS:
        return max(len(line.split()) - 1, 0)
    return line.count(separator)

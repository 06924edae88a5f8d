"""Findings about a recording: one line each, with the first row and a count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import one_line


@dataclass(frozen=True)
class Problem:
    """One finding of the check.

    Attributes:
        severity: "error" or "warning".
        file: The recording, campaign.yaml or the folder.
        message: What is wrong.
        row: Data row from 1 (the header is row 0), None when a whole column
            or file is concerned.
        column: The channel, None when whole rows are concerned.
    """

    severity: str
    file: str
    message: str
    row: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        place = self.file
        if self.row is not None:
            place += f", row {self.row} (line {self.row + 1})"
        if self.column is not None:
            place += f", column {self.column}"
        return one_line(f"{self.severity}: {place}: {self.message}")


def by_message(problems: Sequence[Problem]) -> list[str]:
    """A line for each problem; one for all files of which the same is told."""
    alike: dict[tuple, list[Problem]] = {}
    for p in problems:
        key = p.severity, p.message, p.row, p.column
        alike.setdefault(key, []).append(p)
    lines = []
    for same in alike.values():
        more = len(same) - 1
        others = f" (and {counted(more, 'other file')} alike)" if more else ""
        lines.append(f"{same[0]}{others}")
    return lines


def counted(number: int, noun: str) -> str:
    """Such as "1 row" or "3 rows"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def error(file: str, message: str, column: str | None = None) -> Problem:
    """An error about a whole file or column."""
    return Problem("error", file, message, column=column)


def warning(file: str, message: str, column: str | None = None) -> Problem:
    """A warning about a whole file or column."""
    return Problem("warning", file, message, column=column)


def at_rows(
    file: str,
    column: str | None,
    where: np.ndarray,
    message: str,
    filled: bool = False,
) -> Problem:
    """One problem for all marked rows.

    Args:
        file: The recording.
        column: The channel, None when whole rows are concerned.
        where: Marks of the data rows, shape (N,), bool, at least one.
        message: What is wrong with the first of them.
        filled: Whether straight lines stand in, which is a warning.
    """
    rows = np.flatnonzero(where)
    if filled:
        message += "; filled by a straight line"
    if rows.size > 1:
        message += f" (first of {rows.size} rows)"
    severity = "warning" if filled else "error"
    return Problem(severity, file, message, int(rows[0]) + 1, column)

"""Wording of findings: one line each, with the first row and a count."""

from __future__ import annotations

import numpy as np

from brace_drake.recording.recording import Problem


def quoted(value: object, length: int = 60) -> str:
    """`value` as it would be typed, on one line and not too long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= length else text[: length - 3] + "..."


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
    severity: str = "error",
) -> list[Problem]:
    """One problem for all marked rows, none when no row is marked.

    Args:
        file: The recording.
        column: The channel, None when whole rows are concerned.
        where: Marks of the data rows, shape (N,), bool.
        message: What is wrong with the first of them.
        severity: "error" or "warning".
    """
    rows = np.flatnonzero(where)
    if rows.size == 0:
        return []
    if rows.size > 1:
        message += f" (first of {rows.size} rows)"
    return [Problem(severity, file, message, int(rows[0]) + 1, column)]

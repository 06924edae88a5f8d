"""A recording's CSV file: from bytes to columns, or to what spoils it."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from brace_drake.core.errors import quoted
from brace_drake.recording.dropouts import can_fill
from brace_drake.recording.findings import (
    Problem,
    at_rows,
    counted,
    error,
)

Columns = dict[str, np.ndarray]


def parse_table(
    data: bytes, file: str, known: Collection[str]
) -> tuple[Columns, list[Problem]]:
    """Parses a CSV file with one header line.

    Args:
        data: The file's content.
        file: Its name, for the problems.
        known: Columns that must hold finite numbers. Others may hold
            anything and become arrays of text where they are not numbers.

    Returns:
        The columns, each of shape (N,), empty when the file cannot be
        taken apart; and the problems. A row of the wrong width and a field
        that is no number read NaN, so that row numbers stay true.
    """
    try:
        text = decode(data)
    except ValueError as e:
        return {}, [error(file, str(e))]
    if not text.strip():
        return {}, [error(file, "the file is empty")]
    lines = text.rstrip("\n").split("\n")
    header = [name.strip() for name in lines[0].split(",")]
    problems = []
    if not {*header} & {*known} or len({*header, ""}) <= len(header):
        problems = _check_header(header, file)
    if any(problem.column is None for problem in problems):
        return {}, problems
    if len(lines) == 1:
        return {}, [*problems, error(file, "only a header, no data rows")]
    is_cut = not text.endswith("\n") and _is_cut(lines)
    values = None if is_cut else _parse_numbers(lines[1:], len(header))
    if values is None:
        columns, found = _parse_fields(lines[1:], header, file, known, is_cut)
        return columns, problems + found
    columns = dict(zip(header, values, strict=True))
    for name in columns:
        if name in known and not np.isfinite(columns[name]).all():
            problems.append(_not_finite(columns[name], file, name))
    return columns, problems


def decode(data: bytes) -> str:
    """Text with plain line ends.

    Raises:
        ValueError: It is no text; the message says why.
    """
    if b"\0" in data:
        raise ValueError("not a text file (it holds null bytes)")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        row = data[: e.start].count(b"\n")
        raise ValueError(f"not UTF-8 text (line {row + 1})") from e
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return "_" not in field


def _check_header(header: list[str], file: str) -> list[Problem]:
    """Problems of the header; those without a column are fatal."""
    if len(header) == 1 and (";" in header[0] or "\t" in header[0]):
        return [error(file, "the fields must be separated by commas")]
    if all(map(_is_number, header)):
        return [error(file, "no header line: the first line holds numbers")]
    if "" in header:
        place = header.index("") + 1
        return [error(file, f"the header's column {place} has no name")]
    return [
        error(file, f"the header names it {header.count(name)} times", name)
        for name in dict.fromkeys(header)
        if header.count(name) > 1
    ]


def _is_cut(lines: list[str]) -> bool:
    """Whether the last line, without a line end, stops in mid-row.

    A row that lost only the last digits of its last field shows by having
    fewer decimals than all rows before it.
    """
    if len(lines) < 3:
        return lines[-1].count(",") < lines[0].count(",")
    if lines[-1].count(",") < lines[-2].count(","):
        return True
    fields = [line.rsplit(",", 1)[-1].strip() for line in lines[-21:]]
    if not _is_number(fields[-1]):
        return True
    decimals = [len(field.partition(".")[2]) for field in fields]
    return len(set(decimals[:-1])) == 1 and decimals[-1] < decimals[0]


def _parse_numbers(rows: list[str], width: int) -> np.ndarray | None:
    """All columns, shape (width, N), or None when anything looks odd."""
    if not all(rows):
        return None
    try:
        values = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    return values.T if values.shape == (len(rows), width) else None


def _parse_fields(
    lines: list[str],
    header: list[str],
    file: str,
    known: Collection[str],
    is_cut: bool,
) -> tuple[Columns, list[Problem]]:
    """Columns of a file in which some rows or fields are spoilt."""
    rows = [line.split(",") for line in lines]
    lost = np.array([len(row) != len(header) for row in rows])
    lost[-1] &= not is_cut
    problems = []
    if lost.any():
        found = counted(len(rows[int(np.argmax(lost))]), "field")
        message = f"{found} instead of {len(header)}"
        problems.append(at_rows(file, None, lost, message))
    if is_cut:
        lost[-1] = True
        last = np.arange(len(rows)) == len(rows) - 1
        message = "the file is cut off in the middle of this last row"
        problems.append(at_rows(file, None, last, message))
    columns = {}
    for i, name in enumerate(header):
        texts = [
            "nan" if is_lost else row[i].strip()
            for row, is_lost in zip(rows, lost, strict=True)
        ]
        words = np.array([not _is_number(text) for text in texts])
        if name not in known:
            kind = str if words.any() else float
            columns[name] = np.array(texts, dtype=kind)
            continue
        if words.any():
            problems.append(_not_numbers(texts, words, file, name))
        values = np.array(
            [
                np.nan if is_word else float(text)
                for text, is_word in zip(texts, words, strict=True)
            ]
        )
        if not np.isfinite(values[~(lost | words)]).all():
            problems.append(_not_finite(values, file, name, lost | words))
        columns[name] = values
    return columns, problems


def _not_numbers(
    texts: list[str], words: np.ndarray, file: str, name: str
) -> Problem:
    """The problem of fields that hold something but numbers."""
    text = texts[int(np.argmax(words))]
    message = f"{quoted(text)} is not a number"
    if not text:
        message = "the field is empty, not a number"
    empty = not any(texts[i] for i in np.flatnonzero(words))
    return at_rows(file, name, words, message, empty and _fills(name, words))


def _not_finite(
    values: np.ndarray, file: str, name: str, told: np.ndarray | bool = False
) -> Problem:
    """The problem of numbers that are not finite, but for those told before."""
    bad = ~np.isfinite(values) & ~np.asarray(told)
    message = f"{values[int(np.argmax(bad))]} is not a finite number"
    fills = not np.isinf(values[bad]).any() and _fills(name, bad)
    return at_rows(file, name, bad, message, fills)


def _fills(name: str, lost: np.ndarray) -> bool:
    return name != "time_s" and can_fill(lost)

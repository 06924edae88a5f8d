"""A recording's CSV file: from bytes to columns, or to what spoils it."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from brace_drake.recording.dropouts import can_fill
from brace_drake.recording.findings import at_rows, counted, error, quoted
from brace_drake.recording.recording import Problem

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
        text = _decode(data)
    except ValueError as e:
        return {}, [error(file, str(e))]
    lines = text.rstrip("\n").split("\n")
    if not text.strip():
        return {}, [error(file, "the file is empty")]
    header = [name.strip() for name in lines[0].split(",")]
    problems = _check_header(header, file)
    if any(problem.column is None for problem in problems):
        return {}, problems
    if len(lines) == 1:
        return {}, [*problems, error(file, "only a header, no data rows")]
    is_cut = not text.endswith("\n") and _is_cut(lines)
    values = None if is_cut else _parse_fast(lines[1:], len(header))
    reported: Columns = {}
    if values is not None:
        columns = dict(zip(header, values, strict=True))
    else:
        fields = [line.split(",") for line in lines[1:]]
        lost = _lost_rows(fields, len(header), is_cut)
        problems += _describe_lost(fields, len(header), file, lost, is_cut)
        columns, reported = _parse_slowly(fields, header, known, lost)
        problems += _describe_fields(fields, header, file, reported, lost)
    for name in dict.fromkeys(header):
        if name in known:
            seen = reported.get(name, False)
            problems += _check_finite(columns[name], name, file, seen)
    return columns, problems


def _decode(data: bytes) -> str:
    """Text with plain line ends; ValueError says what is not text."""
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
    if all(_is_number(name) for name in header):
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


def _parse_fast(rows: list[str], width: int) -> np.ndarray | None:
    """All columns, shape (width, N), or None when anything looks odd."""
    if not all(rows):
        return None
    try:
        values = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    return values.T if values.shape == (len(rows), width) else None


def _lost_rows(fields: list[list[str]], width: int, is_cut: bool) -> np.ndarray:
    """Marks of the rows that cannot be told apart into columns."""
    lost = np.array([len(row) != width for row in fields])
    lost[-1] |= is_cut
    return lost


def _describe_lost(
    fields: list[list[str]],
    width: int,
    file: str,
    lost: np.ndarray,
    is_cut: bool,
) -> list[Problem]:
    """One problem for rows of a wrong width, one for a cut last row."""
    last = np.arange(len(fields)) == len(fields) - 1
    wrong = lost & ~(last & is_cut)
    number = len(fields[int(np.argmax(wrong))])
    found = counted(number, "field")
    return [
        *at_rows(file, None, wrong, f"{found} instead of {width}"),
        *at_rows(
            file,
            None,
            last & is_cut,
            "the file is cut off in the middle of this last row",
        ),
    ]


def _parse_slowly(
    fields: list[list[str]],
    header: list[str],
    known: Collection[str],
    lost: np.ndarray,
) -> tuple[Columns, Columns]:
    """Columns of a file in which some rows or fields are spoilt.

    Returns:
        The columns and, for the known ones, marks of the values that were
        replaced by NaN.
    """
    columns, reported = {}, {}
    for i, name in enumerate(header):
        texts = [
            "nan" if is_lost else row[i]
            for row, is_lost in zip(fields, lost, strict=True)
        ]
        bad = np.array([not _is_number(text) for text in texts])
        if name in known:
            texts = [
                "nan" if is_bad else text
                for text, is_bad in zip(texts, bad, strict=True)
            ]
            reported[name] = bad | lost
        is_text = bad.any() and name not in known
        columns[name] = np.array(texts, dtype=str if is_text else float)
    return columns, reported


def _describe_fields(
    fields: list[list[str]],
    header: list[str],
    file: str,
    reported: Columns,
    lost: np.ndarray,
) -> list[Problem]:
    """One problem per known column that holds something but numbers."""
    problems = []
    for name, marks in reported.items():
        bad = marks & ~lost
        if bad.any():
            row = fields[int(np.argmax(bad))]
            text = row[header.index(name)].strip()
            message = f"{quoted(text)} is not a number"
            if not text:
                message = "the field is empty, not a number"
            texts = [fields[i][header.index(name)] for i in np.flatnonzero(bad)]
            fills = not any(t.strip() for t in texts) and _fills(name, bad)
            problems += _at_lost(file, name, bad, message, fills)
    return problems


def _check_finite(
    values: np.ndarray, name: str, file: str, seen: np.ndarray | bool
) -> list[Problem]:
    bad = ~np.isfinite(values) & ~np.asarray(seen)
    if not bad.any():
        return []
    value = values[int(np.argmax(bad))]
    message = f"{value} is not a finite number"
    fills = not np.isinf(values[bad]).any() and _fills(name, bad)
    return _at_lost(file, name, bad, message, fills)


def _fills(name: str, lost: np.ndarray) -> bool:
    return name != "time_s" and can_fill(lost)


def _at_lost(file, name, lost, message, fills) -> list[Problem]:
    """An error, or a warning where straight lines stand in."""
    if fills:
        message += "; filled by a straight line"
    severity = "warning" if fills else "error"
    return at_rows(file, name, lost, message, severity)

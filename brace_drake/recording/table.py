"""A recording's CSV file: from bytes to columns, or to what spoils it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

import numpy as np

from brace_drake.core.errors import ReadError, quoted
from brace_drake.core.reading.rows import (
    NUMBER,
    WORD,
    Rows,
    decode_lines,
    is_number,
    read_rows,
)
from brace_drake.recording.dropouts import can_fill
from brace_drake.recording.findings import (
    Problem,
    at_rows,
    counted,
    error,
)

Columns = dict[str, np.ndarray]
# Of remarks in columns that nobody has declared.
_MOST_TEXTS, _LONGEST = 500_000, 200


def parse_table(
    data: bytes, file: str, known: Collection[str]
) -> tuple[Columns, list[Problem]]:
    """Parses a CSV file with one header line.

    Args:
        data: The file's content.
        file: Its name, for the problems.
        known: Columns that must hold finite numbers. Others may hold
            anything; those with words become arrays of text.

    Returns:
        The columns, each of shape (N,), empty when the file cannot be
        taken apart; and the problems. A row of the wrong width and a field
        that is no number read NaN, so that row numbers stay true.
    """
    try:
        text = decode_lines(data)
    except ReadError as e:
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
        try:
            rows = read_rows((s.split(",") for s in lines[1:]), len(header))
        except ReadError as e:
            return {}, [*problems, error(file, str(e))]
        columns, found = _parse_fields(rows, header, file, known, is_cut)
        columns |= _take_texts(lines[1:], rows, header, known)
        return columns, problems + found
    columns = dict(zip(header, values, strict=True))
    for name in columns:
        if name in known and not np.isfinite(columns[name]).all():
            problems.append(_not_finite(columns[name], file, name))
    return columns, problems


def _check_header(header: list[str], file: str) -> list[Problem]:
    """Problems of the header; those without a column are fatal."""
    if len(header) == 1 and (";" in header[0] or "\t" in header[0]):
        return [error(file, "the fields must be separated by commas")]
    if all(map(is_number, header)):
        return [error(file, "no header line: the first line holds numbers")]
    if "" in header:
        place = header.index("") + 1
        return [error(file, f"the header's column {place} has no name")]
    return [
        error(file, f"the header names it {count} times", name)
        for name, count in Counter(header).items()
        if count > 1
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
    if not is_number(fields[-1]):
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
    rows: Rows,
    header: list[str],
    file: str,
    known: Collection[str],
    is_cut: bool,
) -> tuple[Columns, list[Problem]]:
    """Columns of a file in which some rows or fields are spoilt."""
    lost = rows.widths != len(header)
    lost[-1] &= not is_cut
    problems = []
    if lost.any():
        found = counted(int(rows.widths[np.argmax(lost)]), "field")
        message = f"{found} instead of {len(header)}"
        problems.append(at_rows(file, None, lost, message))
    if is_cut:
        lost[-1] = True
        rows.values[-1] = np.nan
        last = np.arange(len(lost)) == len(lost) - 1
        message = "the file is cut off in the middle of this last row"
        problems.append(at_rows(file, None, last, message))
    columns = dict(zip(header, rows.values.T, strict=True))
    for i, name in enumerate(header):
        if name not in known:
            continue
        words = (rows.kinds[:, i] != NUMBER) & ~lost
        if words.any():
            problems.append(_not_numbers(rows, i, words, file, name))
        values = rows.values[:, i]
        if not np.isfinite(values[~(lost | words)]).all():
            problems.append(_not_finite(values, file, name, lost | words))
    return columns, problems


def _take_texts(
    lines: list[str], rows: Rows, header: list[str], known: Collection[str]
) -> Columns:
    """Columns with words in them as text; NaN stays where they are too many."""
    places = {
        name: i
        for i, name in enumerate(header)
        if name not in known and (rows.kinds[:, i] == WORD).any()
    }
    if not places or len(places) * len(lines) > _MOST_TEXTS:
        return {}
    texts: dict[str, list[str]] = {name: [] for name in places}
    for line in lines:
        fields = line.split(",")
        for name, i in places.items():
            whole = len(fields) == len(header)
            texts[name].append(fields[i].strip()[:_LONGEST] if whole else "nan")
    return {name: np.array(column, object) for name, column in texts.items()}


def _not_numbers(
    rows: Rows, i: int, words: np.ndarray, file: str, name: str
) -> Problem:
    """The problem of fields that hold something but numbers."""
    text = rows.first[i]
    message = f"{quoted(text)} is not a number"
    if not text:
        message = "the field is empty, not a number"
    empty = not (rows.kinds[words, i] == WORD).any()
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

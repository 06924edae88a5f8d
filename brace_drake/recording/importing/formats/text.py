"""Tables as text: CSV and what is like it, with a row of names or without."""

from __future__ import annotations

import codecs
import csv
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError
from brace_drake.core.reading import ReadBytes
from brace_drake.core.reading.rows import (
    WORD,
    Rows,
    decode_lines,
    is_number,
    read_rows,
    with_points,
)
from brace_drake.recording.importing.formats.cells import (
    Table,
    Word,
    is_missing,
    shown,
)
from brace_drake.recording.importing.formats.flatten import distinct

# As a delimiter: blanks and tabs, as many as there are.
BLANKS = " "
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def read_lines(path: Path) -> list[str]:
    """Lines of a text in UTF-8, in UTF-16 with its mark, or in Windows-1252.

    Raises:
        ReadError: It is no text.
    """
    data = ReadBytes(path)
    if data.startswith(_UTF_16):
        try:
            data = data.decode("utf-16").encode()
        except UnicodeDecodeError as error:
            raise ReadError("not a text file") from error
    elif not _is_utf_8(data):
        # Numbers are the same in both; names may have degrees and umlauts.
        data = data.decode("cp1252", errors="replace").encode()
    return decode_lines(data).rstrip("\n").split("\n")


def read_text(
    path: Path, delimiter: str, decimal: str = ".", skipped: int = 0
) -> Table:
    """Columns that hold a number at all, NaN where they hold none.

    Where the first row holds numbers alone there are no names: columns are
    then named by their number, "1" the first. Columns that share a name are
    x(1), x(2).

    Args:
        path: The file.
        delimiter: One character; `BLANKS` is any number of blanks and tabs.
        decimal: What stands before decimals.
        skipped: Lines above the row of names.

    Raises:
        ReadError: One line.
    """
    lines = read_lines(path)[skipped:]
    if len(lines) < 2:
        raise ReadError("no rows below a header")
    try:
        first = next(_fields(lines, delimiter))
        names = [str(i) for i in range(1, len(first) + 1)]
        has_names = not is_row_of_numbers(first, decimal)
        if has_names:
            names = distinct([name.strip() for name in first])
        every = islice(_fields(lines, delimiter), has_names, None)
        rows = read_rows(every, len(names), decimal)
    except (csv.Error, TypeError, ValueError) as error:
        if isinstance(error, ReadError):
            raise
        raise ReadError(f"not a table: {error}") from error
    wrong = np.flatnonzero(rows.widths != len(names))
    if wrong.size:
        raise ReadError(
            f"row {wrong[0] + 1} has {rows.widths[wrong[0]]} fields,"
            f" the header {len(names)}; options.skip_lines says how many lines"
            " come before the header"
        )
    numbers = {
        name: column
        for name, column in zip(names, rows.values.T, strict=True)
        if not np.isnan(column).all()
    }
    every = islice(_fields(lines, delimiter), has_names, None)
    words = _first_words(rows, every)
    return Table(numbers, {names[i]: word for i, word in words.items()})


def _first_words(rows: Rows, every: Iterable[list[str]]) -> dict[int, Word]:
    """Of each column with fields that are neither numbers nor missing, the
    first.
    """
    found: dict[int, Word] = {}
    is_word = rows.kinds == WORD
    wanted = np.flatnonzero(is_word.any(axis=0)).tolist()
    for number, fields in enumerate(every if wanted else (), 1):
        for i in [i for i in wanted if is_word[number - 1, i]]:
            if not is_missing(fields[i]):
                found[i] = Word(number, shown(fields[i].strip()))
                wanted.remove(i)
        if not wanted:
            break
    return found


def _fields(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    """Fields of each line that has any."""
    return filter(None, split_lines(lines, delimiter))


def split_lines(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    """Fields of each line."""
    if delimiter == BLANKS:
        return (line.split() for line in lines)
    return _quoted_lines(lines, delimiter)


def _quoted_lines(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    reader = csv.reader(lines, delimiter=delimiter, strict=True)
    for number, fields in enumerate(reader, 1):
        if reader.line_num != number:
            raise ReadError(f"row {number}: a quote is open at its end")
        yield fields


def is_row_of_numbers(fields: list[str], decimal: str = ".") -> bool:
    """Whether there are fields, and each is a number."""
    return bool(fields) and all(map(is_number, with_points(fields, decimal)))


def _is_utf_8(data: bytes) -> bool:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True

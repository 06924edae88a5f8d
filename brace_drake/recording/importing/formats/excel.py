"""Sheets of Excel: a row of names, and rows of numbers below."""

from __future__ import annotations

import datetime
import zipfile
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from brace_drake.core.errors import ReadError
from brace_drake.core.reading.files import LARGEST, most_bytes
from brace_drake.recording.importing.formats.cells import Samples, Table
from brace_drake.recording.importing.formats.flatten import distinct, pick

_WIDEST = 1000


def read_excel(path: Path, group: str | None, skipped: int = 0) -> Table:
    """Columns that hold a number at all, NaN where they hold none.

    Dates and times are seconds, formulas what they were last.

    Args:
        path: *.xlsx or *.xlsm.
        group: The sheet; not needed where there is one alone.
        skipped: Rows above the row of names.

    Raises:
        ReadError: One line.
        ImportError: openpyxl is not installed.
    """
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(member.file_size for member in archive.infolist())
    if unpacked > 8 * most_bytes(LARGEST):
        raise ReadError("unpacks to more than memory is meant for")
    values, formulas = (
        _rows(path, group, skipped, data_only) for data_only in (True, False)
    )
    every = _cells(values, formulas)
    names = _names(next(every, ()))
    samples = Samples()
    for row in every:
        if any(cell is not None for cell in row):
            cells = map(_seconds, row)
            samples.add(dict(zip(names, cells, strict=False)))
    return samples.table()


def _rows(
    path: Path, group: str | None, skipped: int, data_only: bool
) -> Iterator[tuple]:
    """Cells of a sheet, row by row: values, or formulas as they are typed."""
    import openpyxl

    book = openpyxl.load_workbook(
        path, read_only=True, data_only=data_only, keep_links=False
    )
    sheets = {sheet.title: sheet for sheet in book.worksheets}
    sheet = sheets[pick("sheet", sheets, group)]
    # A sheet may say that it is larger than it is.
    sheet.reset_dimensions()
    for row in islice(sheet.iter_rows(), skipped, None):
        yield row[:_WIDEST]


def _cells(values: Iterable[tuple], formulas: Iterator[tuple]) -> Iterator:
    """What cells hold, row by row: where a formula has no value, itself.

    Args:
        values: Rows of cells.
        formulas: The same as they are typed; they are read only so far as
            values are missing.
    """
    at = 0
    for number, row in enumerate(values):
        cells = [cell.value for cell in row]
        # An empty text is a value.
        missing = [
            i
            for i, cell in enumerate(row)
            if cell.value is None and cell.data_type == "n"
        ]
        if missing:
            typed = next(islice(formulas, number - at, None))
            at = number + 1
            for i in missing:
                cells[i] = _formula(typed[i])
        yield cells


def _formula(cell) -> str | None:
    """A formula as a word, None where there is none."""
    if cell.data_type != "f":
        return None
    text = getattr(cell.value, "text", cell.value)
    return f"{str(text)[:40]} (a formula, its value is not in the file)"


def _names(header: Iterable) -> list[str]:
    return distinct(
        [
            str(i) if name is None else str(name).strip()
            for i, name in enumerate(header, 1)
        ]
    )


def _seconds(cell) -> object:
    """A cell; dates since 1970 and times of day as seconds."""
    if isinstance(cell, datetime.time):
        cell = datetime.datetime.combine(datetime.date(1970, 1, 1), cell)
    if isinstance(cell, datetime.datetime):
        cell = cell - datetime.datetime(1970, 1, 1)
    if isinstance(cell, datetime.timedelta):
        return cell.total_seconds()
    return cell

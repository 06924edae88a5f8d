"""Sheets of Excel: a row of names, and rows of numbers below."""

from __future__ import annotations

import datetime
import math
import zipfile
from array import array
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError
from brace_drake.core.reading.files import LARGEST, most_bytes
from brace_drake.recording.importing.formats.flatten import (
    Arrays,
    check_room,
    distinct,
    pick,
)

_WIDEST = 1000


def read_excel(path: Path, group: str | None, skipped: int = 0) -> Arrays:
    """Columns that hold a number at all, NaN where they hold something else.

    Dates and times are seconds, formulas what they were last.

    Args:
        path: *.xlsx or *.xlsm.
        group: The sheet; not needed where there is one alone.
        skipped: Rows above the row of names.

    Raises:
        ReadError: One line.
        ImportError: openpyxl is not installed.
    """
    import openpyxl

    with zipfile.ZipFile(path) as archive:
        unpacked = sum(member.file_size for member in archive.infolist())
    if unpacked > 8 * most_bytes(LARGEST):
        raise ReadError("unpacks to more than memory is meant for")
    book = openpyxl.load_workbook(
        path, read_only=True, data_only=True, keep_links=False
    )
    sheets = {sheet.title: sheet for sheet in book.worksheets}
    sheet = sheets[pick("sheet", sheets, group)]
    # A sheet may say that it is larger than it is.
    sheet.reset_dimensions()
    rows = sheet.iter_rows(values_only=True)
    for _ in range(skipped):
        next(rows, None)
    return dict(_columns(rows))


def _columns(rows: Iterator[tuple]) -> Iterator[tuple[str, np.ndarray]]:
    header = next(rows, ())[:_WIDEST]
    columns = [array("d") for _ in header]
    for count, row in enumerate(rows, 1):
        check_room(count * len(columns))
        if all(cell is None for cell in row):
            continue
        for i, column in enumerate(columns):
            column.append(_number(row[i]) if i < len(row) else math.nan)
    for name, column in zip(_names(header), columns, strict=True):
        values = np.array(column)
        if len(values) and not np.isnan(values).all():
            yield name, values


def _names(header: Iterable) -> list[str]:
    return distinct(
        [
            str(i) if name is None else str(name).strip()
            for i, name in enumerate(header, 1)
        ]
    )


def _number(cell) -> float:
    if isinstance(cell, bool | int | float):
        return float(cell)
    if isinstance(cell, datetime.datetime):
        return (cell - datetime.datetime(1970, 1, 1)).total_seconds()
    if isinstance(cell, datetime.timedelta):
        return cell.total_seconds()
    if isinstance(cell, datetime.time):
        since = datetime.datetime.combine(datetime.date(1970, 1, 1), cell)
        return (since - datetime.datetime(1970, 1, 1)).total_seconds()
    return math.nan

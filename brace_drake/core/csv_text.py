"""Tables as CSV text that a spreadsheet opens as they are."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence

# What a spreadsheet takes for the begin of a formula.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def csv_text(
    columns: Sequence[str], rows: Iterable[Sequence | Mapping[str, object]]
) -> str:
    """A head and its rows, each a line.

    Text that a spreadsheet would run as a formula has an apostrophe before it
    (OWASP, CSV injection); numbers stay.

    Args:
        columns: Of the head.
        rows: Cells in their order, or by column; one that is None or missing is
            empty.

    Raises:
        ValueError: A row has a cell of a column that is not in the head.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([_safe(c) for c in columns])
    known = {*columns}
    for row in rows:
        if isinstance(row, Mapping):
            if not row.keys() <= known:
                raise ValueError(f"{sorted(row.keys() - known)} in no column")
            row = [row.get(c) for c in columns]
        writer.writerow([_safe(c) for c in row])
    return text.getvalue()


def _safe(cell: object) -> object:
    if not (isinstance(cell, str) and cell.startswith(_FORMULA)):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell

"""Rows and columns as pandas tables, where pandas is installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from brace_drake.core.errors import BraceError, ExtraError, quoted, suggest

Rows = Sequence[Mapping[str, Any]]


def make_frame(content: Rows | Mapping[str, Any]) -> Any:
    """A DataFrame of rows, or of columns by name.

    Raises:
        ExtraError: pandas is not installed.
    """
    try:
        import pandas
    except ImportError as error:
        raise ExtraError(
            "tables need one more package: pip install pandas, or this one"
            " with its extra [pandas]"
        ) from error
    if isinstance(content, Mapping):
        return pandas.DataFrame(dict(content))
    return pandas.DataFrame([dict(row) for row in content])


def pick_frames(tables: Mapping[str, Rows], name: str | None) -> Any:
    """DataFrames by name, or the one of a name.

    Raises:
        BraceError: No table of that name.
        ExtraError: pandas is not installed.
    """
    if name is None:
        return {key: make_frame(rows) for key, rows in tables.items()}
    if name not in tables:
        hint = suggest(name, tables)
        there = " There" if hint else "; there"
        raise BraceError(
            f"no table {quoted(name)}{hint}{there} are {', '.join(tables)}"
        )
    return make_frame(tables[name])

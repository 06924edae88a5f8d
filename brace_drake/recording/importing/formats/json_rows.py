"""JSON: a list of samples, a map of columns, or a sample in each line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from brace_drake.core.errors import ReadError, quoted
from brace_drake.core.reading import ReadBytes, decode, parse_json
from brace_drake.core.reading.json_text import LARGEST_MB
from brace_drake.recording.importing.formats.cells import (
    Column,
    Samples,
    Table,
    make_table,
)
from brace_drake.recording.importing.formats.flatten import cells_of


def read_json(path: Path, group: str | None) -> Table:
    """Columns of numbers; NaN where a sample has none.

    Args:
        path: *.json, or *.jsonl and *.ndjson with a sample in each line.
        group: Key of the map to look in; by default the file itself.

    Raises:
        ReadError: One line.
    """
    data = ReadBytes(path, LARGEST_MB)
    if path.suffix.lower() == ".json":
        found = parse_json(data, may_be_nan=True)
    else:
        found = _parse_lines(decode(data))
    if group is not None:
        if not isinstance(found, dict) or group not in found:
            raise ReadError(f"no key {quoted(group)}")
        found = found[group]
    if isinstance(found, dict):
        return _from_columns(found)
    if isinstance(found, list) and all(isinstance(s, dict) for s in found):
        return _from_samples(found)
    raise ReadError(
        "allowed: a list of samples, each a map of names to numbers, or a map"
        " of names to lists of numbers"
    )


def _parse_lines(text: str) -> list:
    """What each line holds that is not empty."""
    found = []
    for number, line in enumerate(text.split("\n"), 1):
        if line.strip():
            found.append(_parse_line(number, line))
    return found


def _parse_line(number: int, line: str) -> Any:
    try:
        return parse_json(line.encode(), may_be_nan=True)
    except ReadError as error:
        words, cause = str(error), error.__cause__
        if isinstance(cause, json.JSONDecodeError):
            words = f"not JSON: {cause.msg}: column {cause.colno}"
        raise ReadError(f"line {number}: {words}") from error


def _from_columns(found: dict) -> Table:
    columns: dict[str, Column] = {}
    for name, cells in found.items():
        if isinstance(cells, list):
            columns[name] = Column()
            columns[name].extend(cells)
    return make_table(columns)


def _from_samples(found: list[dict]) -> Table:
    samples = Samples()
    for sample in found:
        samples.add(cells_of(sample))
    return samples.table()

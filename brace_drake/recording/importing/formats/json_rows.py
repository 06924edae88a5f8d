"""JSON: a list of samples, a map of columns, or a sample in each line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted
from brace_drake.core.reading import ReadBytes, parse_json
from brace_drake.core.reading.json_text import LARGEST_MB
from brace_drake.recording.importing.formats.flatten import (
    Arrays,
    all_different,
    check_room,
    numbers_in,
)


def read_json(path: Path, group: str | None) -> Arrays:
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
        lines = data.strip().replace(b"\r", b"").split(b"\n")
        found = parse_json(b"[" + b",".join(filter(None, lines)) + b"]", True)
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


def _from_columns(found: dict) -> Arrays:
    lists = {n: v for n, v in found.items() if isinstance(v, list)}
    return {
        name: np.array([_number(value) for value in values])
        for name, values in lists.items()
        if any(math.isfinite(_number(value)) for value in values)
    }


def _from_samples(samples: list[dict]) -> Arrays:
    flat = [all_different(list(numbers_in("", s))) for s in samples]
    names = dict.fromkeys(name for sample in flat for name in sample)
    check_room(len(names) * len(flat))
    return {
        name: np.array([sample.get(name, math.nan) for sample in flat])
        for name in names
    }


def _number(value) -> float:
    return float(value) if isinstance(value, int | float) else math.nan

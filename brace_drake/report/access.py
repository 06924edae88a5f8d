"""Parts of a diagnosis, whether or not they are there."""

from __future__ import annotations

import math

from brace_drake.report.words import to_number


def part(source: object, *keys: str) -> dict:
    """The mapping under the keys; empty where there is none."""
    for key in keys:
        source = source.get(key) if isinstance(source, dict) else None
    return source if isinstance(source, dict) else {}


def items(source: object, key: str) -> list:
    """The list under the key; empty where there is none."""
    value = source.get(key) if isinstance(source, dict) else None
    return list(value) if isinstance(value, list | tuple) else []


def rows(source: object, key: str) -> list[dict]:
    """The mappings of the list under the key."""
    return [row for row in items(source, key) if isinstance(row, dict)]


def names(source: object, key: str) -> list[str]:
    """The texts of the list under the key."""
    return [str(v) for v in items(source, key) if v is not None]


def text(source: dict, key: str) -> str:
    """The text under the key; empty where there is none."""
    value = source.get(key)
    return "" if value is None else str(value)


def numbers(source: list[dict], key: str) -> list[float]:
    """One number per row, NaN where there is none."""
    return [to_number(row.get(key)) for row in source]


def bar_width(share: object) -> float:
    """A share as the width of a bar, %, within 0 to 100."""
    value = to_number(share)
    if not math.isfinite(value):
        return 0.0
    return round(100.0 * min(max(value, 0.0), 1.0), 1)

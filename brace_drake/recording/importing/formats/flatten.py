"""Arrays of any shape as columns by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from brace_drake.core.errors import ReadError, quoted, suggest
from brace_drake.core.reading.files import LARGEST, most_bytes

Arrays = dict[str, np.ndarray]


def as_columns(arrays: Mapping[str, np.ndarray]) -> Arrays:
    """Vectors as they are, and columns of matrices, which count from 1."""
    columns: Arrays = {}
    for name, array in arrays.items():
        if array.ndim == 1 and array.size > 1:
            columns[name] = array
        elif array.ndim == 2:
            for i, column in enumerate(array.T, 1):
                columns[f"{name}({i})"] = column
    return columns


def numbers_in(name: str, value) -> Iterator[tuple[str, float]]:
    """Numbers of a sample: fields within fields a.b, items of lists a[0].

    Args:
        name: Of what is within.
        value: What JSON can hold.
    """
    if isinstance(value, dict):
        for key, item in value.items():
            yield from numbers_in(f"{name}.{key}" if name else str(key), item)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from numbers_in(f"{name}[{i}]", item)
    elif isinstance(value, int | float):
        yield name, float(value)


def check_room(count: int) -> None:
    """Refuses more numbers than memory is meant for.

    Raises:
        ReadError: One line.
    """
    if count > most_bytes(LARGEST) // 4:
        raise ReadError("holds more numbers than memory is meant for")


def pick(kind: str, groups: Mapping[str, object], wanted: str | None) -> str:
    """The group to read: the one that is wanted, or the only one.

    Args:
        kind: What a group is called: sheet, topic.
        groups: By name.
        wanted: `group` of the options.

    Raises:
        ReadError: There is none of that name, or there are several.
    """
    if wanted is None and len(groups) == 1:
        return next(iter(groups))
    names = ", ".join(map(quoted, groups)) or "none"
    if wanted is None:
        raise ReadError(f"options.group must name a {kind}; there are {names}")
    if wanted not in groups:
        hint = suggest(wanted, groups) or f"; there are {names}"
        raise ReadError(f"no {kind} {quoted(wanted)}{hint}")
    return wanted

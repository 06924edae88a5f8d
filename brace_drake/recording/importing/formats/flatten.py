"""Arrays of any shape as columns by name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.core.errors import ReadError, quoted, suggest
from brace_drake.core.reading.files import LARGEST, most_bytes

Arrays = dict[str, np.ndarray]
_MOST_COLUMNS = 100_000


def as_columns(arrays: Mapping[str, np.ndarray]) -> Arrays:
    """Vectors as they are, and columns of matrices, which count from 1.

    Raises:
        ReadError: There are more numbers or columns than memory is meant for.
    """
    check_room(sum(array.size for array in arrays.values()))
    widths = [a.shape[1] if a.ndim == 2 else 1 for a in arrays.values()]
    if sum(widths) > _MOST_COLUMNS:
        raise ReadError(f"has {sum(widths)} columns; allowed: {_MOST_COLUMNS}")
    columns: Arrays = {}
    for name, array in arrays.items():
        if array.ndim == 1 and array.size > 1:
            columns[name] = array
        elif array.ndim == 2:
            for i, column in enumerate(array.T, 1):
                columns[f"{name}({i})"] = column
    return columns


def cells_of(value: object) -> dict[str, object]:
    """Cells of a sample by name: fields within fields a.b, items of lists a[0].

    Args:
        value: What JSON can hold.

    Raises:
        ReadError: There are more than a sample has, or a name is there twice.
    """
    pairs: list[tuple[str, object]] = []
    seen = 0
    # From the last to the first, so that names keep their order.
    within = [("", value)]
    while within:
        name, node = within.pop()
        if not isinstance(node, dict | list):
            pairs.append((name, node))
            continue
        # Before any of them has a name: a list can be the whole file.
        seen += len(node)
        check_sample(seen)
        within += _items(name, node)
    return all_different(pairs)


def _items(name: str, node: dict | list) -> list[tuple[str, object]]:
    """What a map or a list holds, the last first."""
    if isinstance(node, list):
        found = [(f"{name}[{i}]", item) for i, item in enumerate(node)]
    elif name:
        found = [(f"{name}.{key}", item) for key, item in node.items()]
    else:
        found = list(node.items())
    found.reverse()
    return found


def check_sample(count: int) -> None:
    """Refuses a sample of more numbers than a table can have columns.

    Raises:
        ReadError: One line.
    """
    if count > _MOST_COLUMNS:
        raise ReadError(
            f"a sample has {count} values; allowed: {_MOST_COLUMNS}"
        )


def distinct(names: Sequence[str]) -> list[str]:
    """Names of which each is there once: x(1), x(2) where one is there twice,
    so that nobody takes one of them for the other.
    """
    count, seen = Counter(names), Counter[str]()
    found = []
    for name in names:
        seen[name] += 1
        is_alone = count[name] == 1
        found.append(name if is_alone else f"{name}({seen[name]})")
    return found


def all_different(pairs: Sequence[tuple[str, object]]) -> dict[str, object]:
    """Cells of a sample by name.

    Raises:
        ReadError: A name is there twice.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(n for n in found if names.count(n) > 1)
        raise ReadError(f"{quoted(twice)} is there twice in a sample")
    return found


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

"""The values of a tree of numbers: one by one, and of what kind they are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from brace_drake.scenario.messages import fail


def walk(node, at: str = "") -> Iterator[tuple[str, object]]:
    """Key paths and values of all leaves."""
    if dataclasses.is_dataclass(node):
        children = [
            (f"{at}.{f.name}" if at else f.name, getattr(node, f.name))
            for f in dataclasses.fields(node)
        ]
    elif isinstance(node, dict):
        children = [(f"{at}.{key}", child) for key, child in node.items()]
    elif isinstance(node, list):
        children = [(f"{at}[{i}]", child) for i, child in enumerate(node)]
    else:
        yield at, node
        return
    for path, child in children:
        yield from walk(child, path)


def check_kind(source: str, path: str, value, default) -> None:
    """Refuses a value that is of another kind, or size, than its default.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    if isinstance(default, np.ndarray):
        _check_array(source, path, value, default)
    elif isinstance(default, bool | np.bool_):
        if not isinstance(value, bool | np.bool_):
            fail(source, path, value, "true or false")
    elif isinstance(default, str):
        if not isinstance(value, str):
            fail(source, path, value, "a word")
    elif isinstance(value, bool) or not isinstance(
        value, int | float | np.number
    ):
        fail(source, path, value, "a number")
    elif not math.isfinite(value):
        fail(source, path, value, "a finite number")


def _check_array(source: str, path: str, value, default) -> None:
    shape = default.shape
    if not isinstance(value, np.ndarray) or value.shape != shape:
        fail(source, path, value, f"{shape[0]} numbers")
    if not (np.issubdtype(value.dtype, np.number) and np.isfinite(value).all()):
        fail(source, path, value, "finite numbers")

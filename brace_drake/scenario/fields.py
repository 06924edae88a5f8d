"""Fields of a scenario: each declares what it may hold, one checker holds it.

    mass: float = number(0.85, "kg", above=0.0)

Units are SI; SI units stand in messages of values that are not allowed.
"""

from __future__ import annotations

import dataclasses
import math
import typing
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np

from brace_drake.core.errors import ScenarioError, quoted, suggest
from brace_drake.core.reading import HUGE

_KINDS = {bool: "true or false", int: "a whole number", str: "a word"}


@dataclass(frozen=True)
class Limits:
    """What a field may hold; every number of an array alike.

    Attributes:
        unit: Of the numbers.
        above: Numbers are greater.
        least, most: Numbers lie between, these included.
        words: One of these.
        or_infinite: Numbers may be infinite: what is limited by nothing.
        per_ring: Numbers of a ring where there may be those of one ring, for
            all, or of each; 0: as many as the default has.
    """

    unit: str = ""
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    words: tuple[str, ...] = ()
    or_infinite: bool = False
    per_ring: int = 0

    @property
    def in_words(self) -> str:
        """What numbers are allowed."""
        if self.above > -math.inf and self.most < math.inf:
            most = f"{self.most:g} {self.unit}".rstrip()
            allowed = f"greater than {self.above:g}, {most} at most"
        elif self.most < math.inf:
            allowed = f"{self.least:g} to {self.most:g} {self.unit}"
        elif self.above > -math.inf:
            allowed = f"greater than {self.above:g} {self.unit}"
        else:
            allowed = f"{self.least:g} or more {self.unit}"
        return allowed.rstrip()


def number(default: float, unit: str = "", **limits):
    """A field that holds a number within Limits."""
    return field(default=default, metadata=_declare(unit, limits))


def vector(*default: float, unit: str = "", **limits):
    """A field that holds an array of numbers within Limits."""
    return field(
        default_factory=lambda: np.array(default, dtype=float),
        metadata=_declare(unit, limits),
    )


def word(*words: str):
    """A field that holds one of these words; the first is the default."""
    return field(default=words[0], metadata=_declare("", {"words": words}))


def items(*default):
    """A field that holds a list."""
    return field(default_factory=lambda: list(default))


def _declare(unit: str, limits: dict) -> dict:
    return {"limits": Limits(unit, **limits)}


def fail(source: str, path: str, value, allowed: str) -> NoReturn:
    """Raises the one line of a bad value."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    # Keys of a file may be anything, even line breaks.
    path = path if path.isprintable() else repr(path)
    raise ScenarioError(
        f"{source}: {path} is {quoted(value)}; allowed: {allowed}"
    )


def check_fields(node, source: str, at: str = "", num_rings: int = 1) -> None:
    """Checks every value of a dataclass, and of those within.

    Args:
        node: The dataclass.
        source: Named in the error, such as a file.
        at: Key of the node in it.
        num_rings: That arrays with numbers of each ring are for.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    hints = typing.get_type_hints(type(node))
    for f in dataclasses.fields(node):
        path, value = _join(at, f.name), getattr(node, f.name)
        if dataclasses.is_dataclass(value):
            check_fields(value, source, path, num_rings)
            continue
        read(hints[f.name], value, source, path)
        limits = f.metadata.get("limits")
        if limits is None:
            continue
        if limits.words:
            if value not in limits.words:
                hint = suggest(value, limits.words)
                fail(source, path, value, " or ".join(limits.words) + hint)
            continue
        if isinstance(value, np.ndarray):
            one = limits.per_ring or len(f.default_factory())
            sizes = {one, one * num_rings if limits.per_ring else one}
            if len(value) not in sizes:
                sizes = " or ".join(str(size) for size in sorted(sizes))
                fail(source, path, value, f"{sizes} numbers")
        is_wrong = (
            np.isnan(value) if limits.or_infinite else ~np.isfinite(value)
        )
        if np.any(is_wrong):
            kind = "numbers" if isinstance(value, np.ndarray) else "number"
            which = "" if limits.or_infinite else "finite "
            fail(source, path, value, which + kind)
        within = (limits.least <= value) & (value <= limits.most)
        if limits.above > -math.inf:
            within &= limits.above < value
        if not np.all(within):
            fail(source, path, value, limits.in_words)
        if not limits.or_infinite and np.any(np.abs(value) > HUGE):
            fail(source, path, value, f"-{HUGE:g} to {HUGE:g}")


def merge(node, data, source: str, at: str = "") -> None:
    """Lays a map of keys, as a file has it, over a dataclass in place.

    Raises:
        ScenarioError: A key that is not there, or a value of another kind.
    """
    if not isinstance(data, dict):
        fail(source, at or "the whole text", data, "a map of keys")
    hints = typing.get_type_hints(type(node))
    for key, value in data.items():
        path = _join(at, str(key))
        if key not in hints:
            shown = path if path.isprintable() else repr(path)
            hint = suggest(key, hints)
            raise ScenarioError(f"{source}: {shown}: no such key{hint}")
        own = getattr(node, key)
        if dataclasses.is_dataclass(own):
            merge(own, value, source, path)
        else:
            setattr(node, key, read(hints[key], value, source, path))


def read(kind, value, source: str, path: str):
    """A value, of a file or of a field, as its declared kind.

    Raises:
        ScenarioError: It is of another kind.
    """
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if isinstance(value, np.generic):
        value = value.item()
    if dataclasses.is_dataclass(kind):
        if isinstance(value, kind):
            check_fields(value, source, path)
            return value
        value, data = kind(), value
        merge(value, data, source, path)
        return value
    if kind is np.ndarray:
        entries = value.tolist() if isinstance(value, np.ndarray) else value
        return np.array(read(list[float], entries, source, path))
    if origin is list:
        if not isinstance(value, list):
            fail(source, path, value, "a list")
        return [
            read(arguments[0], entry, source, f"{path}[{i}]")
            for i, entry in enumerate(value)
        ]
    if origin is dict:
        if not isinstance(value, dict):
            fail(source, path, value, "a map of keys")
        return {
            key: read(arguments[1], entry, source, f"{path}.{key}")
            for key, entry in value.items()
        }
    if kind is float:
        try:
            # YAML takes 1e-3 for a word; 1_0 and digits of other scripts are
            # none of ours.
            is_word = isinstance(value, str)
            is_plain = not is_word or (value.isascii() and "_" not in value)
            if not isinstance(value, bool) and is_plain:
                return float(value)
        except (TypeError, ValueError):
            pass
        fail(source, path, value, "a number")
    if kind in _KINDS and type(value) is not kind:
        fail(source, path, value, _KINDS[kind])
    return value


def _join(at: str, name: str) -> str:
    return f"{at}.{name}" if at else name

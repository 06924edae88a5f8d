"""Options that the functions share, as the commands do."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from brace_drake.core.errors import FitError, quoted
from brace_drake.core.parallel import Workers, open_workers
from brace_drake.core.progress import share_bar
from brace_drake.devices.choice import Choice

Names = str | Collection[str]
Progress = bool | Callable[[str, float], None]


def make_choice(
    effects: Names | None = None,
    without: Names | None = None,
    free: Names | None = None,
    fixed: Mapping[str, float | None] | Names | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> Choice:
    """What is searched and fitted, from a caller's words.

    Args:
        effects, without, free: Names, as one text with commas or several.
        fixed: Values by name; None as a value, or names alone: the scenario's.
        bounds: Lower and upper limit by name.
        priors: Value and tolerance by name.

    Raises:
        FitError: Values or limits are no numbers.
    """
    if fixed is not None and not isinstance(fixed, Mapping):
        fixed = dict.fromkeys(as_names(fixed) or ())
    return Choice(
        as_names(effects),
        as_names(without) or (),
        as_names(free),
        {n: _value(n, v) for n, v in (fixed or {}).items()},
        {n: _two("bounds", n, b) for n, b in (bounds or {}).items()},
        {n: _two("priors", n, p) for n, p in (priors or {}).items()},
    )


def _value(name: str, value: Any) -> float | None:
    try:
        return None if value is None else float(value)
    except (TypeError, ValueError) as error:
        raise FitError(
            f"fixed: {name} is {quoted(value)}; allowed: a number"
        ) from error


def _two(what: str, name: str, given: Any) -> tuple[float, float]:
    try:
        first, second = map(float, given)
    except (TypeError, ValueError) as error:
        raise FitError(
            f"{what}: {name} is {quoted(given)}; allowed: two numbers"
        ) from error
    return first, second


def split_names(text: str) -> tuple[str, ...]:
    """Names with commas between; those within parentheses are of a name."""
    names, depth, begin = [], 0, 0
    for place, sign in enumerate([*text, ","]):
        depth += (sign == "(") - (sign == ")")
        if sign == "," and (depth <= 0 or place == len(text)):
            names.append(text[begin:place].strip())
            begin = place + 1
    return tuple(n for n in names if n)


def as_names(given: str | Collection[str] | None) -> tuple[str, ...] | None:
    """One text with commas, or several names, as names."""
    if given is None:
        return None
    return split_names(given) if isinstance(given, str) else tuple(given)


@contextlib.contextmanager
def open_jobs(jobs: int | None, cluster: str | None) -> Iterator[Workers]:
    """Threads, all cores by default, or the workers of a Dask scheduler."""
    with open_workers(jobs or os.cpu_count() or 1, cluster) as workers:
        yield workers


@contextlib.contextmanager
def tell(progress: Progress) -> Iterator[Callable[[str, float], None]]:
    """What is told of the work: by a bar, to a caller's function, or not."""
    if callable(progress):
        yield progress
    elif progress:
        with share_bar() as say:
            yield say
    else:
        yield lambda what, share: None


def find_diagram(given: str | Callable | None) -> Callable | None:
    """A function that makes a diagram, found where only its name is given."""
    if not isinstance(given, str):
        return given
    from brace_drake.devices.diagram.factory import find_factory

    return find_factory(given)

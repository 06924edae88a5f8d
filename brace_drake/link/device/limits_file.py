"""The file of limits, the same for simulation and hardware."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from brace_drake.core.errors import LimitsError, quoted, suggest
from brace_drake.core.reading import LoadYaml
from brace_drake.core.resources import scenario_path
from brace_drake.link.protocol.limits import (
    BY_STAGE,
    DEFAULT,
    LIMITS,
    Limit,
    Limits,
    each_value,
    of_stage,
)

FILE = "limits.yaml"
_STAGES, _BENCH = 3, (2,)


def LoadLimits(
    path: str | Path | None = None, stages: Sequence[int] = _BENCH
) -> Limits:
    """Reads and checks limits.

    Args:
        path: YAML with a value for each limit by name, SI units; the
            package's own `diagrams/limits.yaml` by default. What it leaves
            out has the default. Where stages differ in size, a list has the
            value of each of the brace's three stages, bottom to top.
        stages: Of the device, from 1; their values are taken.

    Raises:
        LimitsError: One line: file, name, value, what is allowed.
    """
    path = scenario_path(FILE) if path is None else Path(path)
    content = LoadYaml(path, LimitsError, may_be_empty=True)
    for name in content:
        if name not in Limits._fields:
            hint = suggest(name, Limits._fields)
            raise LimitsError(f"{path}: no limit {name}{hint}")
    for name, values in BY_STAGE.items():
        asked = content.get(name, list(values))
        if isinstance(asked, list):
            content[name] = _pick(name, asked, stages, str(path))
    limits = DEFAULT._replace(**content)
    check_limits(limits, str(path))
    return limits


def _pick(name: str, values: list, stages: Sequence[int], source: str):
    """Values of a device's stages; the number alone where it has one."""
    if len(values) != _STAGES:
        raise LimitsError(
            f"{source}: {name} has {len(values)} values; allowed: one number,"
            f" or one of each of the brace's {_STAGES} stages"
        )
    picked = tuple(values[i - 1] for i in stages)
    return picked if len(picked) > 1 else picked[0]


def check_limits(limits: Limits, source: str = "limits") -> None:
    """Refuses values that cannot be limits.

    Raises:
        LimitsError: One line: source, name, value, what is allowed.
    """
    for limit, values in zip(LIMITS, limits, strict=True):
        for value in each_value(values) if limit.by_stage else (values,):
            _check_value(limit, value, source)
    shortest, longest = limits.leg_shortest, limits.leg_longest
    for i in range(max(len(each_value(v)) for v in (shortest, longest))):
        if not of_stage(shortest, i) < of_stage(longest, i):
            raise LimitsError(
                f"{source}: leg_shortest is {of_stage(shortest, i):g} m;"
                f" allowed: less than leg_longest, {of_stage(longest, i):g}"
            )


def _check_value(limit: Limit, value: object, source: str) -> None:
    place = f"{source}: {limit.name} is {quoted(value)}"
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise LimitsError(f"{place}; allowed: a number")
    if not (math.isfinite(value) and 0.0 < value < 1e9):
        raise LimitsError(f"{place} {limit.unit}; allowed: greater than 0")
    if not limit.allows(value):
        raise LimitsError(
            f"{place} {limit.unit}; allowed: {limit.least:g} to {limit.most:g}"
        )

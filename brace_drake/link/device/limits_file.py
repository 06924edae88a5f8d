"""The file of limits, the same for simulation and hardware."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from brace_drake.core.errors import LimitsError, reason, suggest
from brace_drake.core.resources import scenario_path
from brace_drake.link.device.limits import (
    BY_STAGE,
    DEFAULT,
    NAMES,
    Limits,
    check_limits,
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
    import yaml

    path = scenario_path(FILE) if path is None else Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise LimitsError(f"{path}: cannot be read: {reason(error)}") from error
    except yaml.YAMLError as error:
        line = " ".join(str(error).split())
        raise LimitsError(f"{path}: not YAML: {line}") from error
    if content is None:
        content = {}
    if not isinstance(content, dict):
        raise LimitsError(f"{path}: must hold names of limits with values")
    for name in content:
        if name not in NAMES:
            raise LimitsError(f"{path}: no limit {name}{suggest(name, NAMES)}")
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

"""What a unit of a lab's file is in the unit of a channel."""

from __future__ import annotations

import math
from collections.abc import Iterable

from brace_drake.core.errors import suggest
from brace_drake.recording.columns import split_unit

# Of each kind of unit: the channels' own, as the end of a name, and others.
_G = 9.80665
_INCH, _FOOT, _POUND = 0.0254, 0.3048, 4.4482216152605
_KINDS: tuple[tuple[str, dict[str, float]], ...] = (
    ("s", {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}),
    (
        "m",
        {
            "m": 1.0,
            "mm": 1e-3,
            "cm": 1e-2,
            "um": 1e-6,
            "in": _INCH,
            "ft": _FOOT,
        },
    ),
    (
        "rad",
        {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "rev": math.tau},
    ),
    ("m_s", {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "in/s": _INCH}),
    (
        "rad_s",
        {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": math.tau / 60.0},
    ),
    ("m_s2", {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": _G}),
    (
        "N",
        {
            "N": 1.0,
            "mN": 1e-3,
            "cN": 1e-2,
            "kN": 1e3,
            "MN": 1e6,
            "kgf": _G,
            "gf": 1e-3 * _G,
            "lbf": _POUND,
        },
    ),
    (
        "N_m",
        {
            "N m": 1.0,
            "mN m": 1e-3,
            "N mm": 1e-3,
            "N cm": 1e-2,
            "kN m": 1e3,
            "kgf cm": 1e-2 * _G,
            "lbf in": _POUND * _INCH,
            "lbf ft": _POUND * _FOOT,
        },
    ),
)


def is_unit(unit: str, channel: str) -> bool:
    """Whether values of a channel may be in a unit."""
    return unit in dict(_KINDS).get(split_unit(channel)[1], {})


def scale_of(unit: str, channel: str) -> float | str:
    """What values in a unit are multiplied by for a channel.

    Args:
        unit: As a map names it, such as "mm".
        channel: Its name ends in its own unit.

    Returns:
        The factor, or in words what is allowed where the unit is none of the
        channel's.
    """
    own = split_unit(channel)[1]
    units = dict(_KINDS).get(own, {})
    if unit in units:
        return units[unit]
    if not units:
        return f"no unit: {channel} is taken as it is"
    return f"one of {_listed(units)}{suggest(unit, units)}"


def _listed(units: Iterable[str]) -> str:
    return ", ".join(units)

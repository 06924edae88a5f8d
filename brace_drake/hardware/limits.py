"""Limits: one definition for device, host, simulation and file.

Each is a greatest value ("most") or a least one ("least"). The shared ones are
told to the device, which holds them by itself; the others are the host's.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

from brace_drake.errors import LimitsError


class Limit(NamedTuple):
    """A limit: name, unit, "most" or "least", shared, default, meaning."""

    name: str
    unit: str
    side: str
    shared: bool
    default: float
    meaning: str


LIMITS = (
    Limit("leg_force", "N", "most", True, 40.0, "command of a leg"),
    Limit(
        "leg_force_rate", "N/s", "most", True, 5000.0, "change of the command"
    ),
    Limit("leg_shortest", "m", "least", True, 0.116, "length of a leg"),
    Limit("leg_longest", "m", "most", True, 0.166, "length of a leg"),
    Limit("leg_speed", "m/s", "most", True, 0.1, "rate of a leg"),
    Limit("pad_force", "N", "most", True, 50.0, "of the pad that presses more"),
    Limit(
        "pad_preload",
        "N",
        "least",
        True,
        6.4,
        "on both pads at rest, as the pad's force is found with it",
    ),
    Limit("total_force", "N", "most", True, 80.0, "sum of |F| of all rings"),
    Limit("watchdog", "s", "most", True, 0.05, "longest wait for a command"),
    Limit("release_time", "s", "most", True, 0.5, "from a stop to no force"),
    Limit("release_damping", "N s/m", "least", True, 20.0, "of a released leg"),
    Limit("ring_position", "m", "most", False, 0.016, "displacement of a ring"),
    Limit("ring_rotation", "rad", "most", False, 0.1, "rotation of a ring"),
    Limit("tracking_position", "m", "most", False, 0.004, "from virtual pose"),
    Limit("tracking_rotation", "rad", "most", False, 0.04, "from virtual pose"),
    Limit("stiffness", "N/m", "most", False, 12000.0, "desired, translation"),
    Limit("stiffness_rate", "N/m/s", "most", False, 20000.0, "its change"),
    Limit("turn_stiffness", "N m/rad", "most", False, 200.0, "desired"),
    Limit("turn_stiffness_rate", "N m/rad/s", "most", False, 400.0, "change"),
    Limit("stale", "s", "most", False, 0.03, "age of the newest reading"),
    Limit("lost_messages", "", "most", False, 20.0, "in a row"),
    Limit("length_jump", "m", "most", False, 0.0005, "change within a tick"),
    Limit("force_jump", "N", "most", False, 5.0, "change within a tick"),
    Limit("disagreement", "N", "most", False, 15.0, "reading - legs' force"),
    Limit("disagreement_time", "s", "most", False, 0.2, "how long at most"),
    Limit("stuck_travel", "m", "most", False, 0.003, "of others, one still"),
)
SHARED = tuple(limit for limit in LIMITS if limit.shared)
NAMES = tuple(limit.name for limit in LIMITS)

Limits = NamedTuple("Limits", [(limit.name, float) for limit in LIMITS])
Limits.__doc__ = "Values of all limits, SI units, by the names of LIMITS."
DEFAULT = Limits(*(limit.default for limit in LIMITS))


def as_sent(value: float) -> float:
    """The value as four bytes of a message hold it."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def shared_values(limits: Limits) -> tuple[float, ...]:
    """What the device is told, in the order of SHARED."""
    return tuple(getattr(limits, limit.name) for limit in SHARED)


def check_limits(limits: Limits, source: str = "limits") -> None:
    """Refuses values that cannot be limits.

    Raises:
        LimitsError: One line: source, name, value, what is allowed.
    """
    for limit, value in zip(LIMITS, limits, strict=True):
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise LimitsError(
                f"{source}: {limit.name} is {value!r}; allowed: a number"
            )
        if not (math.isfinite(value) and 0.0 < value < 1e9):
            raise LimitsError(
                f"{source}: {limit.name} is {value!r} {limit.unit}; allowed:"
                " greater than 0"
            )
    if not limits.leg_shortest < limits.leg_longest:
        raise LimitsError(
            f"{source}: leg_shortest is {limits.leg_shortest:g} m; allowed:"
            f" less than leg_longest, {limits.leg_longest:g}"
        )


def first_wider(
    asked: tuple[float, ...], allowed: tuple[float, ...]
) -> int | None:
    """Index of the first shared limit that is wider than allowed, or None.

    Args:
        asked, allowed: In the order of SHARED.
    """
    for i, limit in enumerate(SHARED):
        most, bound = as_sent(asked[i]), as_sent(allowed[i])
        if limit.side == "most" and not most <= bound:
            return i
        if limit.side == "least" and not most >= bound:
            return i
    return None


def refuse_wider(
    limits: Limits, allowed: tuple[float, ...], who: str = "the device"
) -> None:
    """Refuses limits wider than a device's.

    Raises:
        LimitsError: Names the limit and both values.
    """
    i = first_wider(shared_values(limits), allowed)
    if i is None:
        return
    limit = SHARED[i]
    word = "at most" if limit.side == "most" else "at least"
    raise LimitsError(
        f"limit {limit.name} is {getattr(limits, limit.name):g} {limit.unit},"
        f" wider than {who} allows: {word} {allowed[i]:g}"
    )

"""Limits: one definition for device, host, simulation and file.

Each is a greatest value ("most") or a least one ("least"). The shared ones are
told to the device, which holds them by itself; the others are the host's. What
depends on a stage's size has a value of each stage, bottom to top, or one for
all of them.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

from brace_drake.core.errors import LimitsError


class Limit(NamedTuple):
    """A limit.

    Attributes:
        name, unit: SI.
        side: "most" or "least".
        shared: Whether the device is told.
        default: Of the bench.
        meaning: In a few words.
        by_stage: Whether each stage may have a value of its own.
    """

    name: str
    unit: str
    side: str
    shared: bool
    default: float
    meaning: str
    by_stage: bool = False


LIMITS = (
    Limit("leg_force", "N", "most", True, 40.0, "command of a leg"),
    Limit(
        "leg_force_rate", "N/s", "most", True, 5000.0, "change of the command"
    ),
    Limit("leg_shortest", "m", "least", True, 0.116, "length of a leg", True),
    Limit("leg_longest", "m", "most", True, 0.166, "length of a leg", True),
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
    Limit(
        "stuck_travel", "m", "most", False, 0.003, "of a stage, one leg still"
    ),
)
SHARED = tuple(limit for limit in LIMITS if limit.shared)
NAMES = tuple(limit.name for limit in LIMITS)

# Where stages differ, the defaults of the brace's stages 1 to 3; of the bench,
# which is stage 2, they are those above.
BY_STAGE = {
    "leg_shortest": (0.160, 0.116, 0.110),
    "leg_longest": (0.209, 0.166, 0.159),
}

Value = float | tuple[float, ...]
Limits = NamedTuple(
    "Limits",
    [(limit.name, Value if limit.by_stage else float) for limit in LIMITS],
)
Limits.__doc__ = (
    "Values of all limits, SI units, by the names of LIMITS; of BY_STAGE one"
    " for all stages, or a tuple with one of each, bottom to top."
)
DEFAULT = Limits(*(limit.default for limit in LIMITS))


def as_sent(value: float) -> float:
    """The value as four bytes of a message hold it."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def of_stage(value: Value, i: int) -> float:
    """The value of stage i, from 0."""
    return value[i] if isinstance(value, tuple) else value


def each_value(value: Value) -> tuple[float, ...]:
    """All numbers of a value."""
    return value if isinstance(value, tuple) else (value,)


def shared_values(limits: Limits, stages: int = 1) -> tuple[Value, ...]:
    """What a device of so many stages is told, in the order of SHARED.

    What is by stage is a tuple with a value of each.
    """
    return tuple(
        tuple(of_stage(getattr(limits, s.name), i) for i in range(stages))
        if s.by_stage
        else getattr(limits, s.name)
        for s in SHARED
    )


def check_limits(limits: Limits, source: str = "limits") -> None:
    """Refuses values that cannot be limits.

    Raises:
        LimitsError: One line: source, name, value, what is allowed.
    """
    for limit, values in zip(LIMITS, limits, strict=True):
        several = isinstance(values, tuple) and limit.by_stage
        for value in values if several else (values,):
            _check_value(limit, value, source)
    shortest, longest = limits.leg_shortest, limits.leg_longest
    for i in range(max(len(each_value(v)) for v in (shortest, longest))):
        if not of_stage(shortest, i) < of_stage(longest, i):
            raise LimitsError(
                f"{source}: leg_shortest is {of_stage(shortest, i):g} m;"
                f" allowed: less than leg_longest, {of_stage(longest, i):g}"
            )


def _check_value(limit: Limit, value: object, source: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise LimitsError(
            f"{source}: {limit.name} is {value!r}; allowed: a number"
        )
    if not (math.isfinite(value) and 0.0 < value < 1e9):
        raise LimitsError(
            f"{source}: {limit.name} is {value!r} {limit.unit}; allowed:"
            " greater than 0"
        )


def first_wider(
    asked: tuple[Value, ...], allowed: tuple[Value, ...]
) -> int | None:
    """Index of the first shared limit that is wider than allowed, or None.

    Args:
        asked, allowed: In the order of SHARED.
    """
    for i, limit in enumerate(SHARED):
        pairs = zip(each_value(asked[i]), each_value(allowed[i]), strict=True)
        if any(_is_wider(limit, a, b) for a, b in pairs):
            return i
    return None


def _is_wider(limit: Limit, asked: float, allowed: float) -> bool:
    asked, allowed = as_sent(asked), as_sent(allowed)
    # Written so that what is no number is wider.
    if limit.side == "most":
        return not asked <= allowed
    return not asked >= allowed


def refuse_wider(
    limits: Limits,
    allowed: tuple[Value, ...],
    who: str = "the device",
    stages: int = 1,
) -> None:
    """Refuses limits wider than a device's.

    Args:
        limits: Asked for.
        allowed: In the order of SHARED, as `shared_values` gives them.
        who: Whose they are.
        stages: That the device has.

    Raises:
        LimitsError: Names the limit and both values.
    """
    asked = shared_values(limits, stages)
    i = first_wider(asked, allowed)
    if i is None:
        return
    limit = SHARED[i]
    word = "at most" if limit.side == "most" else "at least"
    raise LimitsError(
        f"limit {limit.name} is {format_value(asked[i])} {limit.unit},"
        f" wider than {who} allows: {word} {format_value(allowed[i])}"
    )


def format_value(value: Value) -> str:
    """A limit's value in words, such as "0.16, 0.116"."""
    return ", ".join(f"{v:g}" for v in each_value(value))

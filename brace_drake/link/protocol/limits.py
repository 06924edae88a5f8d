"""The one definition of all limits: of device, host, simulation and file.

Each is a greatest value ("most") or a least one ("least"). The shared ones are
told to the device, which holds them by itself; the others are the host's. What
depends on a stage's size has a value of each stage, bottom to top, or one for
all of them.
"""

from __future__ import annotations

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


def shared_values(limits: Limits, stages: int = 1) -> dict[str, Value]:
    """What a device of so many stages is told, by name, in the order of SHARED.

    What is by stage is a tuple with a value of each.
    """
    told = {limit.name: getattr(limits, limit.name) for limit in SHARED}
    for limit in SHARED:
        if limit.by_stage:
            value = told[limit.name]
            told[limit.name] = tuple(of_stage(value, i) for i in range(stages))
    return told


def shared_of(message: tuple) -> dict[str, Value]:
    """The shared limits in a message's values, by name."""
    return {limit.name: getattr(message, limit.name) for limit in SHARED}


def first_wider(
    asked: dict[str, Value], allowed: dict[str, Value]
) -> int | None:
    """Index in SHARED of the first limit wider than allowed, or None."""
    for i, limit in enumerate(SHARED):
        values = each_value(asked[limit.name]), each_value(allowed[limit.name])
        if any(_is_wider(limit, a, b) for a, b in zip(*values, strict=True)):
            return i
    return None


def _is_wider(limit: Limit, asked: float, allowed: float) -> bool:
    asked, allowed = as_sent(asked), as_sent(allowed)
    # Written so that what is no number is wider.
    if limit.side == "most":
        return not asked <= allowed
    return not asked >= allowed


def refuse_wider(
    limits: Limits, allowed: dict[str, Value], stages: int = 1
) -> None:
    """Refuses limits wider than a device's.

    Args:
        limits: Asked for.
        allowed: As `shared_values` gives them.
        stages: That the device has.

    Raises:
        LimitsError: Names the limit and both values.
    """
    asked = shared_values(limits, stages)
    i = first_wider(asked, allowed)
    if i is None:
        return
    limit = SHARED[i]
    raise LimitsError(
        f"limit {limit.name} is {format_value(asked[limit.name])} {limit.unit},"
        f" wider than the device allows: at {limit.side}"
        f" {format_value(allowed[limit.name])}"
    )


def format_value(value: Value) -> str:
    """A limit's value in words, such as "0.16, 0.116"."""
    return ", ".join(f"{v:g}" for v in each_value(value))

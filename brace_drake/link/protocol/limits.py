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
        least, most: Between which any value must lie, of a device too.
        meaning: In a few words.
        by_stage: Whether each stage may have a value of its own.
    """

    name: str
    unit: str
    side: str
    shared: bool
    default: float
    least: float
    most: float
    meaning: str
    by_stage: bool = False

    def allows(self, value: Value) -> bool:
        """Whether all numbers of a value may be a limit at all."""
        # Four bytes of a message hold no more digits.
        least, most = self.least * (1.0 - 1e-6), self.most * (1.0 + 1e-6)
        return all(least <= v <= most for v in each_value(value))


# name, unit, side, shared, default, least, most, meaning, by stage
# fmt: off
LIMITS = tuple(Limit(*row) for row in (
    ("leg_force", "N", "most", True, 40.0, 1.0, 200.0, "command of a leg"),
    ("leg_force_rate", "N/s", "most", True, 5e3, 100.0, 50e3,
     "change of the command"),
    ("leg_shortest", "m", "least", True, 0.116, 0.05, 0.4,
     "length of a leg", True),
    ("leg_longest", "m", "most", True, 0.166, 0.05, 0.4,
     "length of a leg", True),
    ("leg_speed", "m/s", "most", True, 0.1, 1e-3, 0.5, "rate of a leg"),
    ("pad_force", "N", "most", True, 50.0, 1.0, 200.0,
     "of the pad that presses more"),
    ("pad_preload", "N", "least", True, 6.4, 0.1, 50.0,
     "on both pads at rest, as the pad's force is found with it"),
    ("total_force", "N", "most", True, 80.0, 1.0, 500.0,
     "sum of |F| of all rings"),
    ("watchdog", "s", "most", True, 0.05, 5e-3, 1.0,
     "longest wait for a command"),
    ("release_time", "s", "most", True, 0.5, 0.05, 2.0,
     "from a stop to no force"),
    ("release_damping", "N s/m", "least", True, 20.0, 1.0, 100.0,
     "of a released leg"),
    ("ring_position", "m", "most", False, 0.016, 1e-4, 0.05,
     "displacement of a ring"),
    ("ring_rotation", "rad", "most", False, 0.1, 1e-3, 0.5,
     "rotation of a ring"),
    ("tracking_position", "m", "most", False, 0.004, 1e-4, 0.05,
     "from virtual pose"),
    ("tracking_rotation", "rad", "most", False, 0.04, 1e-3, 0.5,
     "from virtual pose"),
    ("stiffness", "N/m", "most", False, 12e3, 1.0, 100e3,
     "desired, translation"),
    ("stiffness_rate", "N/m/s", "most", False, 20e3, 1.0, 10e6, "its change"),
    ("turn_stiffness", "N m/rad", "most", False, 200.0, 0.1, 2e3, "desired"),
    ("turn_stiffness_rate", "N m/rad/s", "most", False, 400.0, 0.1, 100e3,
     "change"),
    ("stale", "s", "most", False, 0.03, 2e-3, 10.0,
     "age of the newest reading"),
    ("lost_messages", "", "most", False, 20.0, 1.0, 1000.0, "in a row"),
    ("length_jump", "m", "most", False, 0.0005, 1e-5, 0.01,
     "change within a tick"),
    ("force_jump", "N", "most", False, 5.0, 0.1, 100.0, "change within a tick"),
    ("disagreement", "N", "most", False, 15.0, 0.1, 200.0,
     "reading - legs' force"),
    ("disagreement_time", "s", "most", False, 0.2, 1e-3, 5.0,
     "how long at most"),
    ("stuck_travel", "m", "most", False, 0.003, 1e-4, 0.05,
     "of a stage, one leg still"),
))
# fmt: on
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


def refuse_other(told: dict[str, Value], held: dict[str, Value]) -> None:
    """Refuses limits that a device does not hold bit for bit.

    Raises:
        LimitsError: Names the limit and both values.
    """
    for name, value in told.items():
        if tuple(map(as_sent, each_value(value))) != each_value(held[name]):
            raise LimitsError(
                f"limit {name} was told as {format_value(value)}, the device"
                f" holds {format_value(held[name])}"
            )


def format_value(value: Value) -> str:
    """A limit's value in words, such as "0.16, 0.116"."""
    return ", ".join(f"{v:g}" for v in each_value(value))

"""What the safety supervisor is given, reads and remembers."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

from brace_drake.link.device.guards import NO_TRIP, Trip
from brace_drake.link.protocol.limits import Limits


class SafetyMode(IntEnum):
    """Where the supervisor is."""

    RELEASED = 0
    ARMED = 1
    STOPPED = 2


class Setup(NamedTuple):
    """What does not change: limits, weight-carrying forces, tick.

    Attributes:
        limits: To be held.
        hold: Leg forces that carry the rings' weight at rest (n,), N.
        period: Of a tick, s.
    """

    limits: Limits
    hold: tuple[float, ...]
    period: float = 1e-3


class Reading(NamedTuple):
    """What a tick knows of the brace.

    Attributes:
        time: When it was measured, s.
        leg_length: (n,), m.
        force: Of each ring on the torso, W (n / 2,), N.
        lost: Messages missing right before this one.
        pose: X of each ring (n,), or None.
        virtual: Virtual pose of each ring (n,), or None.
        expected: Force that the legs leave for the torso (n / 2,), N, or None.
        has_pose: Whether a ring pose fits the leg lengths.
    """

    time: float
    leg_length: Sequence[float]
    force: Sequence[float]
    lost: int = 0
    pose: Sequence[float] | None = None
    virtual: Sequence[float] | None = None
    expected: Sequence[float] | None = None
    has_pose: bool = True


class Memory(NamedTuple):
    """What the supervisor remembers from tick to tick.

    Attributes:
        mode: Of the state machine.
        trip: What stopped it; its cause is NONE before.
        since: When the release began, s.
        start: Commands when it began (n,), N.
        command: Last commands (n,), N.
        clamped: Whether the last command was cut.
        time: Of the last reading, s; below 0 before the first.
        length, speed, force: Last readings.
        origin: Lengths from which travel is counted (n,), m.
        moved: Which legs' readings have changed since (n,).
        disagrees_since: s; below 0 while readings agree.
    """

    mode: SafetyMode
    trip: Trip
    since: float
    start: tuple[float, ...]
    command: tuple[float, ...]
    clamped: bool
    time: float
    length: tuple[float, ...]
    speed: tuple[float, ...]
    force: tuple[float, ...]
    origin: tuple[float, ...]
    moved: tuple[bool, ...]
    disagrees_since: float


def start_memory(setup: Setup) -> Memory:
    """Released for long, nothing read yet."""
    n = len(setup.hold)
    zeros = (0.0,) * n
    return Memory(
        mode=SafetyMode.RELEASED,
        trip=NO_TRIP,
        since=-1e9,
        start=setup.hold,
        command=setup.hold,
        clamped=False,
        time=-1.0,
        length=zeros,
        speed=zeros,
        force=(0.0,) * (n // 2),
        origin=zeros,
        moved=(True,) * n,
        disagrees_since=-1.0,
    )

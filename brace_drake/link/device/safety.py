"""The safety supervisor: one state machine for simulation and hardware.

    RELEASED --arm--> ARMED --trip or stop--> STOPPED --clear--> RELEASED

Armed, a command passes, cut at the limits of force and its rate. What a reading
must not show (`guards`) stops; a stop keeps its cause until it is cleared, and
arming is a step of its own. Whenever it is not armed, the legs get the damped
release (`release`). Every function is pure: the memory that goes in is not
changed, the one that comes out is new.
"""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.link.device import guards
from brace_drake.link.device.guards import NO_TRIP, Trip
from brace_drake.link.device.release import limit_command, release_command
from brace_drake.link.device.safety_memory import (
    Memory,
    Reading,
    SafetyMode,
    Setup,
)
from brace_drake.link.device.stuck import check_stuck, count_travel
from brace_drake.link.protocol.words import Cause


def arm(memory: Memory) -> Memory:
    """Lets commands through; a latched stop must be cleared before.

    Nothing happens in any mode but RELEASED.
    """
    if memory.mode != SafetyMode.RELEASED:
        return memory
    return memory._replace(
        mode=SafetyMode.ARMED,
        origin=memory.length,
        moved=(False,) * len(memory.length),
        disagrees_since=-1.0,
    )


def disarm(memory: Memory, now: float) -> Memory:
    """Begins a release without a latched stop."""
    if memory.mode != SafetyMode.ARMED:
        return memory
    return memory._replace(
        mode=SafetyMode.RELEASED, since=now, start=memory.command
    )


def stop(memory: Memory, trip: Trip, now: float) -> Memory:
    """Latches a stop; the first cause stays."""
    if memory.mode == SafetyMode.STOPPED:
        return memory
    if memory.mode == SafetyMode.ARMED:
        memory = memory._replace(since=now, start=memory.command)
    return memory._replace(mode=SafetyMode.STOPPED, trip=trip)


def clear(memory: Memory) -> Memory:
    """Ends a latched stop; commands pass only after `arm`."""
    if memory.mode != SafetyMode.STOPPED:
        return memory
    return memory._replace(mode=SafetyMode.RELEASED, trip=NO_TRIP)


def advance(
    setup: Setup,
    memory: Memory,
    now: float,
    reading: Reading | None,
    command: Sequence[float] | None,
) -> Memory:
    """One tick.

    Args:
        setup: What does not change.
        memory: Of the last tick.
        now: s.
        reading: Newest, or None where none has come since the last tick.
        command: Asked for (n,), N; None lets the last one stay.

    Returns:
        The new memory; its `command` is what the legs shall do.
    """
    armed = memory.mode == SafetyMode.ARMED
    trip = None
    if reading is not None:
        before, memory = memory, _remember(setup, memory, reading)
        if armed:
            trip = _check_reading(setup, before, memory, reading)
    if armed:
        age, stale = now - memory.time, setup.limits.stale
        since = memory.disagrees_since
        if trip is None and age > stale:
            trip = Trip(Cause.STALE_DATA, 0, age, stale)
        if trip is None and command is not None and not _is_finite(command):
            trip = Trip(Cause.BAD_COMMAND)
        lasts, most = memory.time - since, setup.limits.disagreement_time
        if trip is None and since >= 0.0 and lasts > most:
            trip = Trip(Cause.DISAGREEMENT, 0, lasts, most)
    if trip is not None:
        memory = stop(memory, trip, now)
    if memory.mode != SafetyMode.ARMED:
        released = release_command(
            now - memory.since,
            setup.limits,
            memory.start,
            setup.hold,
            memory.speed,
        )
        return memory._replace(command=released, clamped=False)
    if command is None:
        return memory
    passed = limit_command(setup.limits, memory.command, command, setup.period)
    return memory._replace(command=passed, clamped=passed != tuple(command))


def _is_finite(values: Sequence[float]) -> bool:
    return all(-1e30 < value < 1e30 for value in values)


def _check_reading(
    setup: Setup, before: Memory, memory: Memory, reading: Reading
) -> Trip | None:
    """What a reading shows that it must not; `memory` has taken it already."""
    limits, lost = setup.limits, reading.lost
    if not reading.has_pose:
        return Trip(Cause.NO_POSE)
    if lost > limits.lost_messages:
        return Trip(Cause.LOST_MESSAGES, 0, float(lost), limits.lost_messages)
    trip = guards.check_stroke(limits, memory.length)
    trip = trip or guards.check_force(limits, memory.force)
    elapsed = reading.time - before.time
    if trip is None and before.time >= 0.0 and elapsed > 0.0:
        trip = guards.check_jump(
            limits, before.length, memory.length, before.force, memory.force,
            max(1.0, elapsed / setup.period),
        )  # fmt: skip
        trip = trip or guards.check_speed(limits, memory.speed)
    if trip is None and reading.pose is not None:
        trip = guards.check_pose(limits, reading.pose, reading.virtual)
    return trip or check_stuck(
        limits.stuck_travel, before.origin, before.length, before.moved,
        memory.length,
    )  # fmt: skip


def _remember(setup: Setup, memory: Memory, reading: Reading) -> Memory:
    length = tuple(reading.leg_length)
    elapsed = reading.time - memory.time
    speed = memory.speed
    if memory.time < 0.0:
        memory = memory._replace(length=length, origin=length)
    elif elapsed > 0.0:
        speed = guards.update_speed(speed, memory.length, length, elapsed)
    origin, moved = count_travel(
        setup.limits.stuck_travel,
        memory.origin,
        memory.length,
        memory.moved,
        length,
    )
    since = memory.disagrees_since
    if reading.expected is not None:
        away = guards.largest_disagreement(reading.force, reading.expected)
        if away <= setup.limits.disagreement:
            since = -1.0
        elif since < 0.0:
            since = reading.time
    return memory._replace(
        time=reading.time,
        length=length,
        speed=speed,
        force=tuple(reading.force),
        origin=origin,
        moved=moved,
        disagrees_since=since,
    )

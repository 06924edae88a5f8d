"""A device tick by tick: watchdog, limits, latched stops, leg forces.

What of PROTOCOL.md happens without a message; `firmware` adds the messages.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import NamedTuple

from brace_drake.link.device import guards
from brace_drake.link.device.guards import NO_TRIP, Trip
from brace_drake.link.device.length_servo import (
    ServoMemory,
    follow_lengths,
    start_servo,
)
from brace_drake.link.device.limits_file import check_limits
from brace_drake.link.device.release import limit_command, release_command
from brace_drake.link.protocol.limits import Limits, shared_values
from brace_drake.link.protocol.words import (
    Cause,
    DeviceState,
    Mode,
    Reason,
    StateFlag,
)

# Without any accepted message for so long, a session ends, s.
SESSION = 2.0


class Identity(NamedTuple):
    """What a device says of itself, see HELLO and GEOMETRY."""

    model: str
    identity: str
    firmware: str
    stages: int
    rate_hz: float
    length_resolution: float
    force_resolution: float
    force_range: float
    rest: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    units: str = "m N s rad"
    takes_lengths: bool = False


class Measured(NamedTuple):
    """Readings of a tick: lengths, m, forces, N, marker, m or None."""

    leg_length: tuple[float, ...]
    force: tuple[float, ...]
    marker: tuple[float, ...] | None
    estop: bool = False
    drive_fault: bool = False


Answer = tuple[str, dict]


class DeviceTicks:
    """The part of a device's state machine that time drives.

    Attributes:
        state: Where it is.
        trip: What made the latched stop.
        session: Number of the session, 0 for none.
        tick_count: Control ticks so far, modulo 2^32.
        rejected: Messages refused so far.
        accepted: Commands accepted so far.
    """

    def __init__(
        self,
        identity: Identity,
        limits: Limits,
        hold: Sequence[float],
        seed: int | None = None,
    ):
        check_limits(limits, "limits of the device")
        self.identity, self.hold = identity, tuple(hold)
        self.own_limits = shared_values(limits, identity.stages)
        self.limits = limits
        self.state = DeviceState.BOOT
        self.trip = NO_TRIP
        self.session = 0
        self.tick_count = self.rejected = self.accepted = 0
        self._draw = random.Random(seed)
        self._period = 1.0 / identity.rate_hz
        self._heard = self._fed = self._released = -1e9
        self._start = self._asked = self._command = self.hold
        self._mode: Mode | None = None
        self._servo: ServoMemory | None = None
        self._sequence = 0
        self._mark, self._fits = (0, 0), Reason.ACCEPTED
        self._is_new = self._clamped = False
        self._measured: Measured | None = None
        self._speed = (0.0,) * len(self.hold)
        self._pending: list[Answer] = []

    def tick(self, measured: Measured, now: float) -> list[Answer]:
        """Begins a tick: readings in, what is to be sent out."""
        before, self._measured = self._measured, measured
        if before is not None:
            self._speed = guards.update_speed(
                self._speed,
                before.leg_length,
                measured.leg_length,
                self._period,
            )
        if self.state == DeviceState.BOOT:
            self.state = DeviceState.HELLO
        self.tick_count = (self.tick_count + 1) & 0xFFFFFFFF
        self._watch(now)
        out, self._pending = self._pending, []
        if self.session:
            out.append(("STATE", self._describe()))
        self._is_new = False
        return out

    def _watch(self, now: float) -> None:
        measured = self._measured
        if measured.estop or measured.drive_fault:
            cause = Cause.ESTOP if measured.estop else Cause.DRIVE_FAULT
            if self.state != DeviceState.FAULT:
                self._latch(DeviceState.FAULT, Trip(cause), now)
        if self.state == DeviceState.ARMED:
            waited, most = now - self._fed, self.limits.watchdog
            trip = self._present()
            # A tick's own time is no lateness: the answer is still due.
            if trip is None and waited > most - 0.5 * self._period:
                trip = Trip(Cause.WATCHDOG, 0, waited, most)
            if trip is not None:
                self._stop(trip, now)
        if self.session and now - self._heard > SESSION:
            self.session = 0
            if self.state == DeviceState.DISARMED:
                self.state = DeviceState.HELLO

    def _present(self) -> Trip | None:
        measured = self._measured
        if measured.estop or measured.drive_fault:
            return Trip(Cause.ESTOP)
        return guards.check_shared(
            self.limits, measured.leg_length, self._speed, measured.force
        )

    def _stop(self, trip: Trip, now: float) -> None:
        if self.state not in (DeviceState.STOPPED, DeviceState.FAULT):
            self._latch(DeviceState.STOPPED, trip, now)

    def _latch(self, state: DeviceState, trip: Trip, now: float) -> None:
        self._release(now)
        self.state, self.trip = state, trip
        fields = {"state": state, **trip._asdict()}
        self._pending.append(("FAULT", fields))

    def _release(self, now: float) -> None:
        if self.state == DeviceState.ARMED:
            self._released, self._start = now, self._command

    def _describe(self) -> dict:
        measured, flags = self._measured, StateFlag(0)
        now_released = self.state != DeviceState.ARMED
        for is_set, flag in (
            (self._clamped, StateFlag.CLAMPED),
            (measured.estop, StateFlag.ESTOP),
            (measured.marker is not None, StateFlag.MARKER),
            (not self._is_new, StateFlag.NO_NEW_COMMAND),
            (now_released and self._start != self.hold, StateFlag.RELEASING),
        ):
            if is_set:
                flags |= flag
        return {
            "state": self.state,
            "cause": self.trip.cause,
            "flags": flags,
            "tick": self.tick_count,
            "command": self._sequence,
            "rejected": self.rejected & 0xFFFF,
            "leg_length": measured.leg_length,
            "force": measured.force,
            "marker": measured.marker or (0.0,) * 3,
        }

    @property
    def has_answer(self) -> bool:
        """Whether the command of this tick has come."""
        return self._is_new

    def _wanted(self) -> tuple[tuple[float, ...], bool]:
        """Leg forces that the command asks for; whether it was cut."""
        if self._mode != Mode.LENGTH:
            return self._asked, False
        length = self._measured.leg_length
        self._servo, force, is_cut = follow_lengths(
            self.limits,
            self._servo or start_servo(length),
            self._asked,
            length,
            self.hold,
            self._period,
        )
        return force, is_cut

    def leg_force(self, now: float) -> tuple[float, ...]:
        """What the drives get until the next tick (n,), N."""
        if self.state == DeviceState.FAULT:
            self._start = self._command = self.hold
            return (0.0,) * len(self.hold)
        if self.state == DeviceState.ARMED:
            wanted, is_cut = self._wanted()
            self._command = limit_command(
                self.limits, self._command, wanted, self._period
            )
            self._clamped = is_cut or self._command != tuple(wanted)
            return self._command
        since = now - self._released
        self._command = release_command(
            since, self.limits, self._start, self.hold, self._speed
        )
        self._clamped = False
        if since >= self.limits.release_time:
            self._start = self.hold
        return self._command

"""The device's side of PROTOCOL.md: a state machine without any I/O.

What a firmware engineer builds in C, here for the emulator and the tests. It is
handed messages, readings and the time; it hands back messages and leg forces.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import NamedTuple

from brace_drake.hardware import guards
from brace_drake.hardware.codec import Packet, seal_fits
from brace_drake.hardware.guards import Trip
from brace_drake.hardware.limits import (
    SHARED,
    Limits,
    first_wider,
    shared_values,
)
from brace_drake.hardware.messages import BY_NAME
from brace_drake.hardware.release import limit_command, release_command
from brace_drake.hardware.words import (
    Cause,
    DeviceState,
    Mode,
    Reason,
    StateFlag,
)

# Without any accepted message for so long, a session ends, s.
SESSION = 2.0
_ACCEPTS_LIMITS = (
    DeviceState.HELLO,
    DeviceState.DISARMED,
    DeviceState.STOPPED,
)


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


class Measured(NamedTuple):
    """Readings of a tick: lengths, m, forces, N, marker, m or None."""

    leg_length: tuple[float, ...]
    force: tuple[float, ...]
    marker: tuple[float, ...] | None
    estop: bool = False
    drive_fault: bool = False


Answer = tuple[str, dict]


class Firmware:
    """The state machine of a device.

    Attributes:
        state: Where it is.
        trip: What made the latched stop.
        session: Number of the session, 0 for none.
        tick_count: Control ticks so far.
        rejected: Messages refused so far.
        accepted: Commands accepted so far.
    """

    def __init__(
        self,
        identity: Identity,
        limits: Limits,
        hold: Sequence[float],
        seed: int = 0,
    ):
        self.identity, self.hold = identity, tuple(hold)
        self.own_limits = shared_values(limits)
        self.limits = limits
        self.state = DeviceState.BOOT
        self.trip = Trip(Cause.NONE)
        self.session = 0
        self.tick_count = self.rejected = self.accepted = 0
        self._draw = random.Random(seed)
        self._period = 1.0 / identity.rate_hz
        self._heard = self._fed = self._released = -1e9
        self._start = self._asked = self._command = self.hold
        self._sequence = 0
        self._is_new = self._clamped = False
        self._measured: Measured | None = None
        self._speed = (0.0,) * len(self.hold)
        self._pending: list[Answer] = []

    # Messages

    def receive(self, packet: Packet, now: float) -> list[Answer]:
        """Takes one message; returns answers, names with their fields."""
        if self.state == DeviceState.BOOT:
            return []
        take = getattr(self, f"_on_{packet.name.lower()}", None)
        message = BY_NAME[packet.name]
        if take is None or message.sender == "device":
            self.rejected += 1
            return []
        answers, reason = take(packet, now)
        if reason != Reason.ACCEPTED:
            self.rejected += 1
        elif message.feeds != "nothing" and self.session:
            self._heard = now
        pending, self._pending = self._pending, []
        return pending + answers

    def _on_hello_request(self, packet: Packet, now: float):
        own = self.identity
        hello = {
            "nonce": packet.values.nonce,
            "state": self.state,
            "capabilities": 0,
        }
        names = ("model", "identity", "firmware", "units", "stages", "rate_hz")
        names += ("length_resolution", "force_resolution", "force_range")
        hello |= {name: getattr(own, name) for name in names}
        places = {n: getattr(own, n) for n in ("rest", "lower", "upper")}
        answers = [
            ("HELLO", hello),
            ("GEOMETRY", places),
            ("DEVICE_LIMITS", _named(self.own_limits)),
        ]
        return answers, Reason.ACCEPTED

    def _on_limits(self, packet: Packet, now: float):
        values = tuple(getattr(packet.values, s.name) for s in SHARED)
        reason, index = self._judge_limits(packet, values)
        if reason == Reason.ACCEPTED:
            self.limits = self.limits._replace(**_named(values))
            self.session = self._new_session()
            self._heard = now
            if self.state == DeviceState.HELLO:
                self.state = DeviceState.DISARMED
        session = self.session if reason == Reason.ACCEPTED else 0
        echo = {"reason": reason, "index": index, "session": session}
        echo |= _named(shared_values(self.limits))
        return [("LIMITS_ECHO", echo)], reason

    def _judge_limits(self, packet, values) -> tuple[Reason, int]:
        if not seal_fits(packet, 0):
            return Reason.WRONG_SESSION, 0
        if self.state not in _ACCEPTS_LIMITS:
            return Reason.WRONG_STATE, 0
        for i, value in enumerate(values):
            if not 0.0 < value < 1e9:
                return Reason.BAD_VALUE, i
        wider = first_wider(values, self.own_limits)
        if wider is not None:
            return Reason.LIMIT_TOO_WIDE, wider
        return Reason.ACCEPTED, 0

    def _new_session(self) -> int:
        while True:
            drawn = self._draw.randrange(1, 2**32)
            if drawn != self.session:
                return drawn

    def _on_command(self, packet: Packet, now: float):
        values = packet.values
        reason = self._judge_command(packet)
        if reason == Reason.ACCEPTED and not all(
            -1e30 < v < 1e30 for v in values.values
        ):
            self._stop(Trip(Cause.BAD_COMMAND), now)
            reason = Reason.BAD_VALUE
        if reason == Reason.ACCEPTED:
            self._asked, self._sequence = values.values, packet.sequence
            self._fed, self._is_new = now, True
            self.accepted += 1
        return [], reason

    def _judge_command(self, packet: Packet) -> Reason:
        if self.state != DeviceState.ARMED:
            return Reason.WRONG_STATE
        if not seal_fits(packet, self.session):
            return Reason.WRONG_SESSION
        if packet.values.mode != Mode.FORCE:
            return Reason.NOT_SUPPORTED
        age = self.tick_count - packet.values.tick
        ahead = (packet.sequence - self._sequence) & 0xFFFF
        longest = self.limits.watchdog / self._period
        if not 0 <= age <= longest or not 0 < ahead < 0x8000:
            return Reason.BAD_VALUE
        return Reason.ACCEPTED

    def _on_heartbeat(self, packet: Packet, now: float):
        return [("HEARTBEAT", {"echo_us": packet.time_us})], Reason.ACCEPTED

    def _on_arm(self, packet: Packet, now: float):
        reason = Reason.ACCEPTED
        if self.state != DeviceState.DISARMED or not self.session:
            reason = Reason.WRONG_STATE
        elif not seal_fits(packet, self.session):
            reason = Reason.WRONG_SESSION
        elif self._measured is None or self._present() is not None:
            reason = Reason.CAUSE_PRESENT
        if reason == Reason.ACCEPTED:
            self.state = DeviceState.ARMED
            self._fed, self._sequence = now, packet.sequence
            self._asked = self._command
        return self._answer(packet, reason)

    def _on_disarm(self, packet: Packet, now: float):
        reason = Reason.WRONG_STATE
        if self.state in (DeviceState.ARMED, DeviceState.DISARMED):
            self._release(now)
            self.state = DeviceState.DISARMED
            reason = Reason.ACCEPTED
        return self._answer(packet, reason)

    def _on_stop(self, packet: Packet, now: float):
        known = set(map(int, Cause)) - {int(Cause.NONE)}
        cause = packet.values.cause
        self._stop(Trip(Cause(cause if cause in known else 1)), now)
        return self._answer(packet, Reason.ACCEPTED)

    def _on_clear(self, packet: Packet, now: float):
        reason = Reason.ACCEPTED
        if self.state not in (DeviceState.STOPPED, DeviceState.FAULT):
            reason = Reason.WRONG_STATE
        elif not self.session or not seal_fits(packet, self.session):
            reason = Reason.WRONG_SESSION
        elif packet.values.cause != self.trip.cause:
            reason = Reason.BAD_VALUE
        elif self._measured is None or self._measured.estop:
            reason = Reason.ESTOP_PRESSED
        elif self._present() is not None:
            reason = Reason.CAUSE_PRESENT
        if reason == Reason.ACCEPTED:
            self.trip = Trip(Cause.NONE)
            self.state = DeviceState.DISARMED
        return self._answer(packet, reason)

    def _answer(self, packet: Packet, reason: Reason):
        fields = {
            "request": BY_NAME[packet.name].code,
            "sequence_answered": packet.sequence,
            "reason": reason,
            "state": self.state,
        }
        return [("ANSWER", fields)], reason

    # Ticks

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
        self.tick_count += 1
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
        measured, flags = self._measured, StateFlag.NONE
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

    def leg_force(self, now: float) -> tuple[float, ...]:
        """What the drives get until the next tick (n,), N."""
        if self.state == DeviceState.FAULT:
            self._start = self.hold
            return (0.0,) * len(self.hold)
        if self.state == DeviceState.ARMED:
            wanted = self._asked
            self._command = limit_command(
                self.limits, self._command, wanted, self._period
            )
            self._clamped = self._command != tuple(wanted)
            return self._command
        since = now - self._released
        self._command = release_command(
            since, self.limits, self._start, self.hold, self._speed
        )
        self._clamped = False
        if since >= self.limits.release_time:
            self._start = self.hold
        return self._command


def _named(values: Sequence[float]) -> dict[str, float]:
    return {s.name: float(v) for s, v in zip(SHARED, values, strict=True)}

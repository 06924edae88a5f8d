"""The device's side of PROTOCOL.md: a state machine without any I/O.

What a firmware engineer builds in C, here for the emulator and the tests. It is
handed messages, readings and the time; it hands back messages and leg forces.
"""

from __future__ import annotations

from brace_drake.link.device.guards import NO_TRIP, Trip
from brace_drake.link.device.ticks import Answer, DeviceTicks
from brace_drake.link.protocol.codec import Packet, seal_fits
from brace_drake.link.protocol.limits import (
    SHARED,
    first_wider,
    shared_of,
    shared_values,
)
from brace_drake.link.protocol.messages import BY_NAME, ORDERED
from brace_drake.link.protocol.sequence import is_newer, steps_ahead
from brace_drake.link.protocol.words import Cause, DeviceState, Mode, Reason


class Firmware(DeviceTicks):
    """The whole state machine of a device."""

    def receive(self, packet: Packet, now: float) -> list[Answer]:
        """Takes one message; returns answers, names with their fields."""
        if self.state == DeviceState.BOOT:
            return []
        take = getattr(self, f"_on_{packet.name.lower()}", None)
        message = BY_NAME[packet.name]
        if take is None or message.sender == "device":
            self.rejected += 1
            return []
        self._fits = self._judge_order(packet)
        answers, reason = take(packet, now)
        if reason != Reason.ACCEPTED:
            self.rejected += 1
        elif message.feeds != "nothing" and self.session:
            self._heard = now
        pending, self._pending = self._pending, []
        return pending + answers

    def _judge_order(self, packet: Packet) -> Reason:
        """Whether a message is of this session, and newer than what has come.

        It is remembered even where it is refused: else it would do later, sent
        again, what it was refused to do now.
        """
        if packet.name not in ORDERED:
            return Reason.ACCEPTED
        session = 0 if packet.name == "LIMITS" else self.session
        if packet.sealed_bytes and not seal_fits(packet, session):
            return Reason.WRONG_SESSION
        mark = packet.sequence, packet.time_us
        if self.session and not is_newer(*mark, self._mark):
            return Reason.REPLAYED
        self._mark = mark
        return Reason.ACCEPTED

    def _on_hello_request(self, packet: Packet, now: float):
        own = self.identity
        hello = {
            "nonce": packet.values.nonce,
            "state": self.state,
            "capabilities": int(own.takes_lengths),
        }
        answers = [
            ("HELLO", own._asdict() | hello),
            ("GEOMETRY", own._asdict()),
            ("DEVICE_LIMITS", self.own_limits),
        ]
        return answers, Reason.ACCEPTED

    def _on_limits(self, packet: Packet, now: float):
        values = shared_of(packet.values)
        reason, index = self._judge_limits(packet, values)
        if reason == Reason.ACCEPTED:
            self.limits = self.limits._replace(**values)
            self.session = self._new_session()
            if self.state == DeviceState.HELLO:
                self.state = DeviceState.DISARMED
        session = self.session if reason == Reason.ACCEPTED else 0
        echo = {"reason": reason, "index": index, "session": session}
        echo |= shared_values(self.limits, self.identity.stages)
        return [("LIMITS_ECHO", echo)], reason

    def _judge_limits(self, packet, values) -> tuple[Reason, int]:
        if self.state == DeviceState.ARMED:
            return Reason.WRONG_STATE, 0
        if self._fits != Reason.ACCEPTED:
            return self._fits, 0
        for i, limit in enumerate(SHARED):
            if not limit.allows(values[limit.name]):
                return Reason.BAD_VALUE, i
        legs = zip(values["leg_shortest"], values["leg_longest"], strict=True)
        if not all(shortest < longest for shortest, longest in legs):
            return Reason.BAD_VALUE, list(values).index("leg_longest")
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
            self._mode = Mode(values.mode)
            self._fed, self._is_new = now, True
            self.accepted += 1
        return [], reason

    def _judge_command(self, packet: Packet) -> Reason:
        if self.state != DeviceState.ARMED:
            return Reason.WRONG_STATE
        if self._fits != Reason.ACCEPTED:
            return self._fits
        mode, lengths = packet.values.mode, self.identity.takes_lengths
        if mode != Mode.FORCE and not (lengths and mode == Mode.LENGTH):
            return Reason.NOT_SUPPORTED
        if self._mode not in (None, mode):
            return Reason.BAD_VALUE
        age = steps_ahead(self.tick_count, packet.values.tick, 32)
        if not 0 <= age <= self.limits.watchdog / self._period:
            return Reason.BAD_VALUE
        return Reason.ACCEPTED

    def _on_heartbeat(self, packet: Packet, now: float):
        return [("HEARTBEAT", {"echo_us": packet.time_us})], Reason.ACCEPTED

    def _on_arm(self, packet: Packet, now: float):
        reason = Reason.ACCEPTED
        if self.state != DeviceState.DISARMED or not self.session:
            reason = Reason.WRONG_STATE
        elif self._fits != Reason.ACCEPTED:
            reason = self._fits
        elif self._measured is None or self._present() is not None:
            reason = Reason.CAUSE_PRESENT
        if reason == Reason.ACCEPTED:
            self.state = DeviceState.ARMED
            self._fed, self._sequence = now, packet.sequence
            self._asked, self._mode, self._servo = self._command, None, None
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
        elif not self.session or self._fits != Reason.ACCEPTED:
            reason = self._fits if self.session else Reason.WRONG_SESSION
        elif packet.values.cause != self.trip.cause:
            reason = Reason.BAD_VALUE
        elif self._measured is None or self._measured.estop:
            reason = Reason.ESTOP_PRESSED
        elif self._present() is not None:
            reason = Reason.CAUSE_PRESENT
        if reason == Reason.ACCEPTED:
            self.trip = NO_TRIP
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

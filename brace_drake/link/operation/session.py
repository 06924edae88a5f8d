"""A motion on a device: every state is answered in the thread that reads it."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

import numpy as np

from brace_drake.core.errors import LinkError
from brace_drake.devices.motions.limits import check_reach
from brace_drake.link.device import safety
from brace_drake.link.device.guards import Trip
from brace_drake.link.device.safety_memory import (
    Reading,
    SafetyMode,
    Setup,
    start_memory,
)
from brace_drake.link.host.link import Link
from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.tally import Tally
from brace_drake.link.protocol.codec import Packet
from brace_drake.link.protocol.limits import Limits
from brace_drake.link.protocol.sequence import steps_ahead
from brace_drake.link.protocol.words import Cause, DeviceState, StateFlag

# Most ticks that are bridged: the supervisor has stopped before.
_MOST_BRIDGED = 100
# A released ring may have been pushed away. It is brought home in this time, s;
# until shortly after, it may be far from its virtual pose.
_HOME, _HOME_MARGIN = 0.8, 0.1
# Between two looks at what happens, s.
_PAUSE = 0.02


class Session:
    """Follows a reference on an agreed link under the supervisor.

    Attributes:
        rows: Ticks not yet taken by the recorder.
        done: Whether the whole reference was followed.
        trip: What stopped it, None while nothing has.
        tally: Of the line.
    """

    def __init__(
        self, link: Link, control, limits: Limits, dry_run: bool = False
    ):
        self._link, self._control, self._dry = link, control, dry_run
        self._setup = Setup(limits, control.hold, control.period)
        self._memory = start_memory(self._setup)
        self._desired, self._legs = np.zeros((0, 3)), len(control.hold)
        self._at, self._home_at, self._moving = 0, 0, False
        # Of the last state: the device's count, and ours, which does not wrap.
        self._last_tick = self._last_arrival = None
        self._ticks = 0
        self._last_readings = np.zeros(0)
        self._tick_of: dict[int, int] = {}
        self._told, self._armed, self._now = False, False, 0.0
        self.rows: deque[Row] = deque()
        self.done, self.trip, self.tally = False, None, Tally()
        link.on_state = self._OnState

    def Follow(
        self,
        desired: np.ndarray,
        take: Callable[[list[Row]], None],
        asks_stop: Callable[[], bool] = lambda: False,
        settle: float = 1.0,
    ) -> None:
        """Follows a reference to its end, or until something stops it.

        It watches from another thread than the one that reads, so that a device
        gone silent, an operator's key and an error of ours all stop.

        Args:
            desired, settle: As `Start` takes them.
            take: Called with the ticks since the last call, in order; at the
                end once more.
            asks_stop: Whether the operator wants it stopped.

        Raises:
            LimitsError, LinkError: As `Start` and `Finish`.
        """
        try:
            self.Start(desired, settle)
            while not self.is_over:
                time.sleep(_PAUSE)
                self.CheckAlive()
                if asks_stop():
                    self.Stop(Cause.STOP_KEY)
                take(self._TakeRows())
        except BaseException:
            if self._moving:
                self.Stop(Cause.HOST_ERROR)
            raise
        else:
            # Before the last rows: a full disk must not keep the ring pressed.
            if self.done:
                self.Finish()
        finally:
            take(self._TakeRows())

    def _TakeRows(self) -> list[Row]:
        return [self.rows.popleft() for _ in range(len(self.rows))]

    def Start(self, desired: np.ndarray, settle: float = 1.0) -> None:
        """Arms, holds the rest pose for a while, then follows.

        Args:
            desired: y_d, y_d', y_d'' at each tick (ticks, 3, S).
            settle: s; in its first part the rings come home.

        Raises:
            LimitsError: The reference reaches further than any may.
            LinkError: The device refuses to arm.
        """
        check_reach("asked for", desired[:, 0])
        self._desired, period = desired, self._setup.period
        self._at = -round(settle / period)
        self._control.Reset()
        home = min(_HOME, 0.5 * settle)
        self._control.GoHome(round(home / period))
        self._home_at = self._at + round((home + _HOME_MARGIN) / period)
        self.done, self._moving = False, True
        # A device that never sends a state must not be waited for forever.
        self._last_arrival = self._last_arrival or time.perf_counter()
        if not self._dry:
            try:
                self._link.Arm()
            except LinkError:
                self._moving = False
                raise
            self._armed = True

    def Stop(self, cause: Cause = Cause.STOP_KEY) -> None:
        """Stops at once; both sides latch."""
        self._Trip(Trip(cause))

    def Finish(self) -> None:
        """Releases the ring without a latched stop.

        States are answered until the device has disarmed: where the first
        request is lost, its watchdog must not take the silence for a crash.

        Raises:
            LinkError: The device does not answer, or has stopped meanwhile.
        """
        self._armed = False
        try:
            if not self._dry and self.trip is None:
                self._link.Disarm()
        finally:
            self._moving = False
            self._memory = safety.disarm(self._memory, self._now)

    def CheckAlive(self) -> None:
        """Stops where no state has come for longer than `stale`."""
        if not self._moving or self._last_arrival is None:
            return
        age = time.perf_counter() - self._last_arrival
        most, error = self._setup.limits.stale, self._link.error
        if error is not None:
            gone = isinstance(error, LinkError)
            self._Trip(Trip(Cause.DISCONNECTED if gone else Cause.HOST_ERROR))
        elif age > most:
            self._Trip(Trip(Cause.STALE_DATA, 0, age, most))

    @property
    def is_over(self) -> bool:
        """Whether nothing more will be recorded."""
        return self.done or self.trip is not None

    @property
    def stopped_by(self) -> str:
        """What stopped it in words, with those of an error of our own."""
        error = self._link.error
        told = error is None or isinstance(error, LinkError)
        return str(self.trip) + ("" if told else f": {error}")

    def _Trip(self, trip: Trip) -> None:
        self._memory = safety.stop(self._memory, trip, self._now)
        if self.trip is None:
            self.trip = trip
        self._moving = False
        if not self._told and not self._dry:
            self._told = True
            try:
                self._link.Send("STOP", {"cause": int(trip.cause)})
            except LinkError:
                return

    def _OnState(self, packet: Packet, lost: int) -> None:
        arrived, values = time.perf_counter(), packet.values
        readings = np.array([*values.leg_length, *values.force, *values.marker])
        last = values.tick - 1 if self._last_tick is None else self._last_tick
        ahead = steps_ahead(values.tick, last, 32)
        missing, self._ticks = max(0, ahead - 1), self._ticks + ahead
        # The device's ticks are the supervisor's time: a burst of messages is
        # no jump, and a lost one is a tick all the same.
        self._now = self._ticks * self._setup.period
        if self._last_arrival is not None:
            self.tally.periods.Add(arrived - self._last_arrival)
        self._last_arrival = arrived
        stopped = values.state in (DeviceState.STOPPED, DeviceState.FAULT)
        if not self._moving:
            self._See(readings, missing, None)
        elif stopped and not self._dry:
            self._told = True
            self._Trip(self._Told(values.cause))
        elif values.state == DeviceState.ARMED or self._dry:
            self._memory = safety.arm(self._memory)
            self._Bridge(readings, min(missing, _MOST_BRIDGED))
            self._Control(arrived, values, readings, missing)
        elif self._armed:
            self._Trip(Trip(Cause.DISARMED))
        self._last_tick, self._last_readings = values.tick, readings

    def _Told(self, cause: int) -> Trip:
        """The device's own trip, with its numbers where they have come."""
        if cause not in set(map(int, Cause)):
            cause = Cause.DRIVE_FAULT
        fault = self._link.fault
        if fault is None or fault.values.cause != cause:
            return Trip(Cause(cause))
        return Trip(Cause(cause), *fault.values[2:])

    def _See(self, readings, missing, command) -> None:
        """Shows the supervisor a tick's readings, and the command for it."""
        control, legs = self._control, self._legs
        reading = Reading(
            self._now, readings[:legs].tolist(), readings[legs:-3].tolist(),
            missing, has_pose=control.good,
        )  # fmt: skip
        if command is not None:
            # Driven, and with the time to come home behind it.
            follows = not self._dry and self._at > self._home_at
            reading = reading._replace(
                pose=control.pose,
                virtual=control.virtual if follows else None,
                expected=control.expected.tolist(),
            )
        self._memory = safety.advance(
            self._setup, self._memory, self._now, reading, command
        )

    def _Bridge(self, readings: np.ndarray, missing: int) -> None:
        """Controls the ticks of lost states on interpolated readings."""
        for i in range(missing):
            share = (i + 1) / (missing + 1)
            between = self._last_readings + share * (
                readings - self._last_readings
            )
            command = self._control.Tick(between, self._Reference())
            self._Keep(command, between, 0.0, 0, True)

    def _Control(self, arrived, values, readings, missing) -> None:
        command = self._control.Tick(readings, self._Reference())
        self._See(readings, missing, command.tolist())
        memory = self._memory
        if memory.mode == SafetyMode.STOPPED:
            self._Trip(memory.trip)
            return
        if memory.clamped:
            self._control.Pass(memory.command)
        age = 0
        if not self._dry:
            sent = self._link.Command(memory.command, values.tick)
            self._tick_of[sent] = self._ticks
            answered = self._tick_of.get(values.command)
            age = 1 if answered is None else self._ticks - answered
            if len(self._tick_of) > 1000:
                self._tick_of.pop(next(iter(self._tick_of)))
            if values.flags & StateFlag.NO_NEW_COMMAND and self.tally.ticks:
                self.tally.unanswered += 1
        latency = time.perf_counter() - arrived
        self.tally.latencies.Add(latency)
        self.tally.ages.Add(age)
        self._Keep(np.array(memory.command), readings, latency, age, False)

    def _Reference(self) -> np.ndarray:
        if self._at < 0:
            return np.zeros(self._desired.shape[1:])
        return self._desired[min(self._at, len(self._desired) - 1)]

    def _Keep(self, command, readings, latency, age, bridged) -> None:
        control = self._control
        self.tally.ticks += 1
        self.tally.bridged += bridged
        if 0 <= self._at < len(self._desired):
            self.rows.append(Row(
                self._at, command.copy(), readings, self._Reference(),
                control.y_virtual, control.y_ring, latency, age, bridged,
                control.stiffness,
            ))  # fmt: skip
        self._at += 1
        if self._at >= len(self._desired):
            self.done = True

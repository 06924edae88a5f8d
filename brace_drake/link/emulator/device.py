"""A whole emulated brace: plant, firmware, line, in real time."""

from __future__ import annotations

import gc
import threading
import time
from dataclasses import dataclass

from brace_drake.effects.stack import Use
from brace_drake.link.device.firmware import Firmware
from brace_drake.link.device.ticks import Identity, Measured
from brace_drake.link.emulator.line import Line, LineFaults
from brace_drake.link.emulator.plant import EmulatedPlant
from brace_drake.link.emulator.terminal import Terminal
from brace_drake.link.protocol.codec import (
    Decoder,
    longest_frame,
    make_codec,
)
from brace_drake.link.protocol.limits import DEFAULT, Limits
from brace_drake.link.protocol.words import DeviceState


def measure_plant(
    plant: EmulatedPlant, u, estop: bool, drive_fault: bool
) -> Measured:
    """Advances a plant by one tick under commands (6n,), N; its readings."""
    readings = plant.advance(u).tolist()
    legs = len(plant.hold)
    return Measured(
        tuple(readings[0:legs]),
        tuple(readings[legs:-3]),
        tuple(readings[-3:]),
        estop,
        drive_fault,
    )


@dataclass
class Faults:
    """What may be wrong with the device or its line, changed at any time.

    Attributes:
        to_host, to_device: Of the two directions of the line.
        noise_before_hello: Bytes of noise that are sent at start and before
            each hello.
        estop: Whether the emergency stop is pressed.
        drive_fault: Whether a drive reports a fault.
        stuck_legs: Legs with jammed drives, from 0.
        frozen_legs: Legs whose readings stand still, from 0.
    """

    to_host: LineFaults
    to_device: LineFaults
    noise_before_hello: int = 0
    estop: bool = False
    drive_fault: bool = False
    stuck_legs: tuple[int, ...] = ()
    frozen_legs: tuple[int, ...] = ()


# Forces that carry the rings' weight at rest alone let them sink in the end: so
# long after a release whoever stands by holds them in their place, s.
_STANDS_BY = 3.0


class EmulatedDevice:
    """A device that serves one pseudo-terminal.

    Each tick: readings, STATE out, wait for the answer until the tick is over,
    drive the legs for one period. With `host_paced` the device's time stands
    still for so long, s, or until an armed host has answered: the recording is
    then that of a machine that is never late, whatever else runs on this one.

    Attributes:
        plant, firmware, terminal, faults: Its parts.
        late_ticks: Ticks that began more than half a period late.
        unanswered: Armed ticks that ended without an answer.
    """

    def __init__(
        self,
        plant: EmulatedPlant,
        identity: Identity,
        limits: Limits = DEFAULT,
        link: str | None = None,
        host_paced: float = 0.0,
        seed: int = 0,
    ):
        self.plant, self.host_paced = plant, host_paced
        plant.WarmUp()
        self.firmware = Firmware(identity, limits, plant.hold)
        self.faults = Faults(LineFaults(), LineFaults())
        self.terminal = Terminal(link)
        self.late_ticks = self.unanswered = 0
        self._out = Line(self.faults.to_host, seed + 1)
        self._in = Line(self.faults.to_device, seed + 2)
        self._codec = make_codec(identity.stages)
        self._decoder = Decoder(self._codec)
        self._sequence = 0
        self._period = plant.period
        self._origin = self._lag = 0.0
        self._stop = threading.Event()
        self._torso: bool | None = None
        self._begins: tuple[Use, ...] = ()
        self._armed_at = 0.0
        self._plugged, self._puts_back = True, False
        self._rest, self._is_patient, self._tick_time = b"", True, 0.0

    def stop(self) -> None:
        """Ends `run`, from another thread or a signal handler."""
        self._stop.set()

    def plan_rest(self) -> None:
        """Lets an operator put ring and torso back at rest, unless armed."""
        self._puts_back = True

    def plug(self, is_plugged: bool) -> None:
        """Unplugs the line or plugs it in again, with the next tick."""
        self._plugged = is_plugged

    def plan_torso(self, present: bool) -> None:
        """Lets the torso come or go, with the next tick that is not armed."""
        self._torso = present

    def plan_effect(self, use: Use) -> None:
        """Lets an effect of the library begin with the next tick.

        Raises:
            EffectError: The plant carries no more.
        """
        self.plant.check_room(len(self._begins) + 1)
        self._begins = (*self._begins, use)

    def run(self, duration: float | None = None) -> None:
        """Serves until `stop`, or for so long, s."""
        self._origin = time.perf_counter()
        u, tick = self.plant.hold, 0
        gc.collect()
        gc.freeze()
        self._SendNoise()
        while not self._stop.is_set():
            if duration is not None and tick * self._period > duration:
                break
            if self._plugged != self.terminal.is_connected:
                self._Plug()
            self._Measure(u, tick * self._period)
            self._Listen((tick + 1) * self._period)
            u = self.firmware.leg_force(tick * self._period)
            tick += 1
        self.terminal.disconnect()

    def _Plug(self) -> None:
        if not self._plugged:
            self.terminal.disconnect()
            return
        self.terminal.connect()
        print(f"port: {self.terminal.path}", flush=True)

    @property
    def _is_idle(self) -> bool:
        return self.firmware.state != DeviceState.ARMED

    def _Now(self) -> float:
        """The device's time, s."""
        return time.perf_counter() - self._origin - self._lag

    def _Measure(self, u, now: float) -> None:
        plant, faults, self._tick_time = self.plant, self.faults, now
        if self._torso is not None and self._is_idle:
            plant.with_torso, self._torso = self._torso, None
        if self._begins:
            uses, self._begins = self._begins, ()
            plant.begin_effects(uses)
        if not self._is_idle:
            self._armed_at = now
        elif self._puts_back:
            plant.reset()
            self._puts_back = False
        elif now - self._armed_at > _STANDS_BY and plant.is_away:
            plant.put_rings_back()
        plant.jammed, plant.frozen = (
            set(faults.stuck_legs),
            set(faults.frozen_legs),
        )
        measured = measure_plant(plant, u, faults.estop, faults.drive_fault)
        self._Send(self.firmware.tick(measured, now), now)
        self._Flush()

    def _Listen(self, deadline: float) -> None:
        """Takes messages until the tick is over.

        A tick that begins late is made up for; beyond 20 ms time is stretched.
        """
        begun = self._Now()
        if begun > deadline - 0.5 * self._period:
            self.late_ticks += 1
        if begun - deadline > 0.02:
            self._lag += begun - deadline
        if self.host_paced:
            self._WaitForAnswer()
        left = deadline - self._Now()
        while True:
            due = self._out.next_due, self._in.next_due
            arrives = min((d for d in due if d is not None), default=deadline)
            self._Take(self.terminal.read(min(left, arrives - self._Now())))
            left = deadline - self._Now()
            if left <= 0.0:
                break
        armed = self.firmware.state == DeviceState.ARMED
        if armed and not self.firmware.has_answer:
            self.unanswered += 1

    def _WaitForAnswer(self) -> None:
        """Lets time stand still until an armed host has answered."""
        begun = time.perf_counter()
        firmware = self.firmware
        while firmware.state == DeviceState.ARMED and not firmware.has_answer:
            waited = time.perf_counter() - begun
            gives_up = not self._is_patient or waited > self.host_paced
            if gives_up or self._stop.is_set():
                break
            self._Take(self.terminal.read(0.01))
        # A host that has gone is not waited for again at each tick.
        self._is_patient = (
            firmware.has_answer or firmware.state != DeviceState.ARMED
        )
        self._lag += time.perf_counter() - begun

    def _Take(self, data: bytes) -> None:
        """What has come in goes through the line and to the firmware."""
        now, tick_time = self._Now(), self._tick_time
        if data:
            *frames, rest = (self._rest + data).split(b"\0")
            self._rest = rest[-longest_frame() :]
            for frame in frames:
                if frame:
                    self._in.send(b"\0" + frame + b"\0", now)
        arrived = self._in.take(now)
        for packet in self._decoder.feed(arrived) if arrived else ():
            if packet.name == "HELLO_REQUEST":
                self._SendNoise()
            answers = self.firmware.receive(packet, tick_time)
            self._Send(answers, tick_time if self.host_paced else now)
        self._Flush()

    def _Send(self, answers, now: float) -> None:
        for name, values in answers:
            frame = self._codec.encode(
                name, values, self._sequence, int(1e6 * max(0.0, now))
            )
            self._sequence += 1
            self._out.send(frame, now)

    def _Flush(self) -> None:
        data = self._out.take(self._Now())
        if data:
            self.terminal.write(data)

    def _SendNoise(self) -> None:
        number = self.faults.noise_before_hello
        if number:
            draw = self._out._draw
            self.terminal.write(
                bytes(draw.randrange(256) for _ in range(number))
            )

"""Host and emulated device in lockstep: no threads, no clock, no terminal.

The bench; with another scenario, plant and limits any other device.
"""

import numpy as np

from brace_drake.link.device.firmware import Firmware
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.emulator.device import measure_plant
from brace_drake.link.emulator.line import Line, LineFaults
from brace_drake.link.operation.control import HostControl
from brace_drake.link.operation.session import Session
from brace_drake.link.protocol.codec import Decoder, make_codec
from brace_drake.link.protocol.limits import DEFAULT, shared_values
from brace_drake.link.protocol.sequence import SequenceWatch
from brace_drake.link.protocol.words import Mode
from brace_drake.scenario.brace import BenchScenario

SCENARIO = BenchScenario(time_step=5e-4)


class Lockstep:
    """A bench whose line and device fail on demand; also the session's link.

    Attributes:
        firmware, plant: The device.
        to_host, to_device: Faults of the line.
        estop, drive_fault, host_is_dead: More faults.
        error: Of the link, as a session sees it.
    """

    def __init__(self, limits=DEFAULT, plant=None, seed=0, scenario=SCENARIO):
        self.plant = plant or BenchPlant(SCENARIO, seed=seed)
        self.firmware = Firmware(
            describe_device(scenario, "test"), limits, self.plant.hold, 7
        )
        self.to_host, self.to_device = LineFaults(), LineFaults()
        self._out = Line(self.to_host, seed + 1)
        self._in = Line(self.to_device, seed + 2)
        self._stages = self.firmware.identity.stages
        self._codec = make_codec(self._stages)
        self._host, self._device = (
            Decoder(self._codec),
            Decoder(self._codec),
        )
        self.order, self._sequence = SequenceWatch(), {"h": 0, "d": 0}
        self.estop = self.drive_fault = self.host_is_dead = False
        self.on_state = self.error = None
        self.session, self.now, self.tick = 0, 0.0, 0
        self.states, self.heard = [], []
        self._u = self.plant.hold

    # The session's link

    def Send(self, name, values):
        self._sequence["h"] += 1
        number = self._sequence["h"] & 0xFFFF
        session = 0 if name == "LIMITS" else self.session
        frame = self._codec.encode(
            name, values, number, self.tick * 1000, session
        )
        self._in.send(frame, self.now)
        self._deliver()
        return number

    def Command(self, values, tick):
        fields = {"mode": Mode.FORCE, "tick": tick, "values": values}
        return self.Send("COMMAND", fields)

    def Arm(self):
        self.Send("ARM", {"nonce": 1})

    def Disarm(self):
        self.Send("DISARM", {"nonce": 1})

    def agree(self, limits=DEFAULT):
        """Hello is taken as said; agrees on limits after one tick."""
        self.run(2)
        self.Send("LIMITS", shared_values(limits, self._stages))
        self.run(1)
        echo = next(p for p in self.heard if p.name == "LIMITS_ECHO")
        self.session = echo.values.session
        return echo.values

    @property
    def fault(self):
        faults = [p for p in self.heard if p.name == "FAULT"]
        return faults[-1] if faults else None

    # Ticks

    def run(self, ticks):
        """Advances; stops early at nothing."""
        for _ in range(ticks):
            measured = measure_plant(
                self.plant, self._u, self.estop, self.drive_fault
            )
            self._tell(self.firmware.tick(measured, self.now))
            # Bytes on their way arrive within the tick.
            self._deliver(0.9 * self.plant.period)
            self._u = self.firmware.leg_force(self.now)
            self.states.append(self.firmware.state)
            self.tick += 1
            self.now = self.tick * self.plant.period

    def _tell(self, answers):
        for name, values in answers:
            self._sequence["d"] += 1
            frame = self._codec.encode(
                name, values, self._sequence["d"], round(1e6 * self.now)
            )
            self._out.send(frame, self.now)

    def _deliver(self, later=0.0):
        data = self._out.take(self.now + later)
        for packet in self._host.feed(data) if data else ():
            lost = self.order.take(packet.sequence)
            if lost is None or self.host_is_dead:
                continue
            self.heard.append(packet)
            if packet.name == "STATE" and self.on_state:
                self.on_state(packet, lost)
        data = self._in.take(self.now + later)
        for packet in self._device.feed(data) if data else ():
            self._tell(self.firmware.receive(packet, self.now))


def start(limits=DEFAULT, depth=0.005, seconds=4.0, **more):
    """A bench in lockstep with a session that has settled and moves."""
    bench = Lockstep(limits, **more)
    session = begin(bench, HostControl(SCENARIO), limits, wave(depth, seconds))
    return bench, session


def wave(depth, seconds):
    """y, y', y'' of a ring that goes to a depth and back each 2 s."""
    t = np.arange(round(1e3 * seconds)) * 1e-3
    y = -depth * (1.0 - np.cos(2 * np.pi * 0.5 * t)) / 2.0
    rate = np.gradient(y, 1e-3)
    return np.column_stack([y, rate, np.gradient(rate, 1e-3)])


def begin(device, control, limits, desired):
    """A session that has agreed and armed."""
    device.agree(limits)
    session = Session(device, control, limits)
    session.Start(desired, settle=0.4)
    return session

"""Damaged states on their way to a host that commands a device."""

import math
import threading
import time
from unittest import mock

import numpy as np

from brace_drake.link.device.firmware import Firmware
from brace_drake.link.device.ticks import Measured
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.host.link import Link
from brace_drake.link.operation.control import HostControl
from brace_drake.link.operation.session import Session
from brace_drake.link.protocol.codec import Decoder
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.link.protocol.words import Cause, DeviceState
from brace_drake.scenario.brace import BenchScenario
from link_fuzz.damage import KINDS, Fuzz

# The host's readings have no real time here.
_LIMITS = DEFAULT._replace(stale=1e3)
# After a wrong number that it believed a host may find so many states old.
_MOST_OLD = 100
# Of the damaged frames so many, at most, have a good CRC-16 and a good length:
# well above the one in 65 536 that it lets through.
_MISSED = 4.0 / 65536.0


class Wire:
    """The host's port without a line; its bytes are given, not read.

    So everything happens in one thread, at any speed, alike each time.
    """

    in_waiting = 0

    def __init__(self, take):
        self.link = None
        self._take, self._data, self._is_busy = take, b"", False
        self._closed = threading.Event()

    def read(self, size):
        """Nothing ever comes this way."""
        self._closed.wait()
        return b""

    def give(self, data):
        """Hands bytes to the host, then what answers it meanwhile."""
        self._data += data
        if self._is_busy:
            return
        self._is_busy = True
        while self._data:
            data, self._data = self._data, b""
            self.link._Accept(data, time.perf_counter_ns())
        self._is_busy = False

    def write(self, frame):
        """Hands a frame of the host on; what answers it comes back."""
        self.give(self._take(frame))

    def close(self):
        """As a port has it."""
        self._closed.set()


class ToHost(Fuzz):
    """A device, a damaged line, and the link and the session of a host."""

    def __init__(self, seed: int):
        words = ("clean", "taken", "commands", "wrong", "resync_lost")
        super().__init__(
            seed, (*words, "overtaken", "missed", "forged", "stops")
        )
        scenario = BenchScenario()
        self.control = HostControl(scenario)
        plant = BenchPlant(scenario, seed=None)
        self.rest = plant.advance(plant.hold).tolist()
        who = describe_device(scenario, "fuzzed")
        self.device = Firmware(who, DEFAULT, plant.hold, seed)
        self.commands = Decoder(self.codec)
        self.last, self.old, self.taken = None, 0, 0
        self.is_forged = False
        self.wire = Wire(self.judge)
        with mock.patch(
            "brace_drake.link.host.link.OpenPort", return_value=self.wire
        ):
            self.link = self.wire.link = Link("fuzzed")
        self.wire.give(self.tick())
        self.link.Connect(10.0)
        self.link.Agree(_LIMITS)
        self.begin()

    @property
    def decoder(self):
        """That of the host."""
        return self.link._decoder

    # The device

    def encode(self, answers):
        """Frames of a device's answers."""
        frames = b""
        for name, values in answers:
            self.sequence = (self.sequence + 1) & 0xFFFF
            frame = self.codec.encode(name, values, self.sequence, 1)
            if name == "STATE":
                kept = self.codec.decode(frame[1:-1]).values
                self.sent[self.sequence] = kept
            frames += frame
        return frames

    def tick(self):
        """One tick of the device: the frames that it sends."""
        noise = [self.draw.gauss(0.0, 2e-6) for _ in range(6)]
        pairs = zip(self.rest, noise, strict=False)
        legs = tuple(length + more for length, more in pairs)
        measured = Measured(legs, tuple(self.rest[6:9]), None)
        self.now += 1e-3
        return self.encode(self.device.tick(measured, self.now))

    def judge(self, frame):
        """Takes a frame of the host; the device's answers to it."""
        answers = []
        for packet in self.commands.feed(frame):
            if packet.name == "COMMAND":
                self.check(packet.values.values)
            elif packet.name == "ARM":
                self.last = None
            answers += self.device.receive(packet, self.now)
        return self.encode(answers)

    def check(self, values):
        """A command must hold numbers, within force and its rate."""
        before = self.last or self.device.hold
        most, step = _LIMITS.leg_force, _LIMITS.leg_force_rate * 1e-3
        good = all(
            math.isfinite(v) and abs(v) <= most and abs(v - b) <= step + 1e-4
            for v, b in zip(values, before, strict=True)
        )
        self.last = values
        self.counts["commands"] += 1
        self.counts["wrong"] += not good

    # The host

    def begin(self):
        """Clears what is latched, arms, begins a session."""
        device = self.device
        for _ in range(_MOST_OLD + 2):
            before = self.link.counts.states
            self.wire.give(self.tick())
            if self.link.counts.states > before:
                break
        if device.state == DeviceState.STOPPED:
            self.link.Clear(Cause(device.trip.cause))
        elif device.state == DeviceState.ARMED:
            self.link.Disarm()
        self.session = Session(self.link, self.control, _LIMITS)
        on_state = self.link.on_state

        def take(packet, lost):
            self.counts["taken"] += 1
            self.taken += 1
            if self.sent.get(packet.sequence) != packet.values:
                word = "forged" if self.is_forged else "missed"
                self.counts[word] += 1
            on_state(packet, lost)

        self.link.on_state = take
        self.session.Start(np.zeros((1000, 3)), settle=0.4)
        assert device.state == DeviceState.ARMED, device.state

    def step(self):
        """One damaged state, then a whole one that must come through."""
        armed = self.device.state == DeviceState.ARMED
        if self.session.trip is not None or not armed:
            self.counts["stops"] += 1
            self.begin()
        kind = self.draw.choice(KINDS)
        self.counts[kind] += 1
        frame = self.tick()
        if kind == "reorder":
            self.wire.give(self.tick() + frame)
        else:
            self.line.number = self.sequence
            self.is_forged = kind == "forge"
            self.wire.give(self.line.damage(kind, frame))
            self.is_forged = False
        self.pass_whole()
        self.session.rows.clear()
        self.forget(300)

    def pass_whole(self):
        """A whole state, which must reach the session."""
        self.counts["clean"] += 1
        seen = self.link.counts
        taken, old = self.taken, seen.late + seen.repeated
        self.wire.give(self.tick())
        if self.taken > taken:
            self.old = 0
            return
        self.old += 1
        self.counts["overtaken"] += 1
        seen = self.link.counts
        is_old = seen.late + seen.repeated > old and self.old <= _MOST_OLD
        self.counts["resync_lost"] += not is_old

    def report(self):
        """The rest of what there is to say; whether it is bad."""
        counts, seen = self.counts, self.link.counts
        print(f"lost         {seen.lost}, repeated {seen.repeated}")
        damaged = sum(counts[k] for k in ("corrupt", "truncate", "noise"))
        is_missed = counts["missed"] > 10.0 + _MISSED * damaged
        self.link.Close()
        return is_missed or self.is_bad

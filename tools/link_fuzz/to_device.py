"""Damaged commands on their way to an armed device."""

import struct

from brace_drake.link.device.firmware import Firmware
from brace_drake.link.device.ticks import SESSION, Identity, Measured
from brace_drake.link.protocol.codec import Decoder
from brace_drake.link.protocol.limits import DEFAULT, shared_values
from brace_drake.link.protocol.words import DeviceState
from link_fuzz.damage import KINDS, Fuzz

_REST = Measured((0.141,) * 6, (0.0,) * 3, None)


class ToDevice(Fuzz):
    """An armed device, a host that is never tired, and a line between them."""

    def __init__(self, seed: int):
        super().__init__(
            seed, ("clean", "accepted", "wrong", "resync_lost", "stops")
        )
        self.decoder = Decoder(self.codec)
        who = Identity(
            "x", "y", "z", 1, 1e3, 0, 0, 0, (0.0,) * 3, *[(0.0,) * 18] * 2
        )
        self.device = Firmware(who, DEFAULT, (2.0,) * 6, seed)
        self.arm()

    def encode(self, name, values):
        self.sequence = (self.sequence + 1) & 0xFFFF
        session = 0 if name == "LIMITS" else self.device.session
        return self.codec.encode(name, values, self.sequence, 1, session)

    def arm(self):
        """Begins a session: a forged end may have made the last one's old."""
        device = self.device
        self.now += SESSION + 0.1
        device.tick(_REST, self.now)
        if device.state in (DeviceState.HELLO, DeviceState.STOPPED):
            self.pass_on(self.encode("LIMITS", shared_values(DEFAULT)))
        if device.state == DeviceState.STOPPED:
            cause = int(device.trip.cause)
            self.pass_on(self.encode("CLEAR", {"cause": cause}))
        self.pass_on(self.encode("ARM", {"nonce": 1}))
        assert device.state == DeviceState.ARMED, device.state
        self.sent.clear()

    def command(self):
        tick = self.device.tick_count
        values = tuple(self.draw.uniform(-30.0, 30.0) for _ in range(6))
        values = struct.unpack("<6f", struct.pack("<6f", *values))
        frame = self.encode(
            "COMMAND", {"mode": 0, "tick": tick, "values": values}
        )
        self.sent[self.sequence] = values
        return frame

    def pass_on(self, data):
        """Gives bytes to the device; returns how many messages came out."""
        device, good = self.device, self.decoder.good
        for packet in self.decoder.feed(data):
            before = device.accepted
            device.receive(packet, self.now)
            if device.accepted > before:
                self.counts["accepted"] += 1
                if self.sent.get(packet.sequence) != packet.values.values:
                    self.counts["wrong"] += 1
        return self.decoder.good - good

    def step(self):
        """One damaged frame, then a whole one that must come through."""
        device = self.device
        self.now += 1e-3
        device.tick(_REST, self.now)
        if device.state != DeviceState.ARMED:
            self.counts["stops"] += 1
            self.arm()
        kind = self.draw.choice(KINDS)
        self.counts[kind] += 1
        if kind == "reorder":
            first, second = self.command(), self.command()
            data, last = second + first, self.sequence
            good = self.pass_on(data)
            if good != 2 or device._sequence != last:
                self.counts["resync_lost"] += 1
        else:
            frame = self.command()
            self.line.number = self.sequence
            self.pass_on(self.line.damage(kind, frame))
        if device.state != DeviceState.ARMED:
            return
        self.counts["clean"] += 1
        clean = self.command()
        before = device.accepted
        self.pass_on(clean)
        if device.accepted == before:
            self.counts["resync_lost"] += 1
        self.forget(100)

    def report(self):
        """The rest of what there is to say; whether it is bad."""
        print(f"refused      {self.device.rejected}")
        return self.is_bad

"""Damages frames on their way to an armed device and looks what it does.

    python tools/fuzz_link.py --frames 1000000 --seed 1

Frames are corrupted, truncated, duplicated, reordered, dropped, mixed with
noise, and forged (random content under a good CRC). Status 1 where a command is
accepted that was not sent as it is, where anything raises, or where an
undamaged frame behind a damaged one is lost.
"""

import argparse
import random
import struct
import sys
import time
from binascii import crc_hqx

from brace_drake.hardware.cobs import stuff
from brace_drake.hardware.codec import Decoder, make_codec
from brace_drake.hardware.device_ticks import Identity, Measured
from brace_drake.hardware.firmware import Firmware
from brace_drake.hardware.limits import DEFAULT, SHARED, shared_values
from brace_drake.hardware.messages import MESSAGES, VERSION
from brace_drake.hardware.words import DeviceState

_REST = Measured((0.141,) * 6, (0.0,) * 3, None)
_KINDS = (
    *("corrupt", "truncate", "duplicate", "reorder", "drop"),
    *("noise", "forge", "flip"),
)


class Fuzz:
    """An armed device, a host that is never tired, and a line between them."""

    def __init__(self, seed: int):
        self.draw = random.Random(seed)
        self.codec = make_codec(1)
        self.decoder = Decoder(self.codec)
        who = Identity(
            "x", "y", "z", 1, 1e3, 0, 0, 0, (0.0,) * 3, *[(0.0,) * 18] * 2
        )
        self.device = Firmware(who, DEFAULT, (2.0,) * 6, seed)
        self.sequence, self.now, self.sent = 0, 0.0, {}
        self.counts = dict.fromkeys(
            (*_KINDS, "clean", "accepted", "wrong", "resync_lost", "stops"), 0
        )
        self.arm()

    def encode(self, name, values):
        self.sequence = (self.sequence + 1) & 0xFFFF
        session = 0 if name == "LIMITS" else self.device.session
        return self.codec.encode(name, values, self.sequence, 1, session)

    def arm(self):
        device = self.device
        device.tick(_REST, self.now)
        if device.state in (DeviceState.HELLO, DeviceState.STOPPED):
            values = shared_values(DEFAULT)
            named = {s.name: v for s, v in zip(SHARED, values, strict=True)}
            self.pass_on(self.encode("LIMITS", named))
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

    def damage(self, kind, frame):
        """What becomes of a frame; None keeps it back behind the next."""
        draw, data = self.draw, bytearray(frame)
        if kind == "corrupt":
            for _ in range(draw.randint(1, 12)):
                data[draw.randrange(len(data))] = draw.randrange(256)
        elif kind == "flip":
            bit = draw.randrange(8 * len(data))
            data[bit // 8] ^= 1 << bit % 8
        elif kind == "truncate":
            a, b = sorted(draw.sample(range(len(data) + 1), 2))
            del data[a:b]
        elif kind == "duplicate":
            data *= 2
        elif kind == "drop":
            data.clear()
        elif kind == "noise":
            size = draw.choice((1, 7, 80, 700))
            data = bytearray(draw.randbytes(size)) + data
        elif kind == "forge":
            data = bytearray(self.forge()) + data
        return bytes(data)

    def forge(self):
        """Random content under a good CRC, of a size that fits."""
        draw = self.draw
        message = draw.choice(MESSAGES)
        head = struct.pack(
            "<BBHQ", VERSION, message.code, draw.randrange(2**16), 1
        )
        body = head + draw.randbytes(self.codec.size(message.name))
        return (
            b"\0"
            + stuff(body + struct.pack("<H", crc_hqx(body, 0xFFFF)))
            + b"\0"
        )

    def step(self):
        """One damaged frame, then a whole one that must come through."""
        device, draw = self.device, self.draw
        self.now += 1e-3
        device.tick(_REST, self.now)
        if device.state != DeviceState.ARMED:
            self.counts["stops"] += 1
            self.arm()
        kind = draw.choice(_KINDS)
        self.counts[kind] += 1
        if kind == "reorder":
            first, second = self.command(), self.command()
            data, last = second + first, self.sequence
            good = self.pass_on(data)
            if good != 2 or device._sequence != last:
                self.counts["resync_lost"] += 1
        else:
            self.pass_on(self.damage(kind, self.command()))
        if device.state != DeviceState.ARMED:
            return
        self.counts["clean"] += 1
        clean = self.command()
        before = device.accepted
        self.pass_on(clean)
        if device.accepted == before:
            self.counts["resync_lost"] += 1
        if len(self.sent) > 1000:
            for number in list(self.sent)[:-100]:
                del self.sent[number]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    fuzz, begun = Fuzz(args.seed), time.perf_counter()
    for _ in range(args.frames):
        fuzz.step()
    seconds = time.perf_counter() - begun
    for name, number in fuzz.counts.items():
        print(f"{name:12} {number}")
    bad = {k: v for k, v in fuzz.decoder.bad.items() if v}
    print(f"not messages {bad}\nrefused      {fuzz.device.rejected}")
    print(f"buffer       {len(fuzz.decoder._rest)} bytes")
    print(f"took         {seconds:.0f} s")
    return int(fuzz.counts["wrong"] > 0 or fuzz.counts["resync_lost"] > 0)


if __name__ == "__main__":
    sys.exit(main())

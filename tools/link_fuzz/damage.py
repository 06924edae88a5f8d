"""What a line, or worse, may do to a frame."""

import random
import struct
from binascii import crc_hqx

from brace_drake.link.protocol.cobs import stuff
from brace_drake.link.protocol.codec import make_codec
from brace_drake.link.protocol.messages import MESSAGES, VERSION
from brace_drake.link.protocol.words import DeviceState

KINDS = (
    *("corrupt", "truncate", "duplicate", "reorder", "drop"),
    *("noise", "forge", "flip"),
)


class Fuzz:
    """One way of a damaged line, between a device and its host.

    Attributes:
        counts: What was done, and what came of it.
    """

    BAD = ("wrong", "resync_lost")

    def __init__(self, seed: int, words):
        self.line = Damage(seed)
        self.draw, self.codec = self.line.draw, self.line.codec
        self.sequence, self.now, self.sent = 0, 0.0, {}
        self.counts = dict.fromkeys((*KINDS, *words), 0)

    def forget(self, kept: int):
        """Of what was sent only the last is compared."""
        if len(self.sent) > 1000:
            for number in list(self.sent)[:-kept]:
                del self.sent[number]

    @property
    def is_bad(self) -> bool:
        return any(self.counts[name] for name in self.BAD)


class Damage:
    """What becomes of a frame, by a seed.

    Attributes:
        number: Of the next frame, which half of the forged ones have.
    """

    def __init__(self, seed: int):
        self.draw = random.Random(seed)
        self.codec = make_codec(1)
        self.number = 0

    def damage(self, kind, frame):
        """Bytes in place of a frame, of a kind but "reorder"."""
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
        number = draw.choice((self.number, draw.randrange(2**16)))
        head = struct.pack("<BBHQ", VERSION, message.code, number, 1)
        payload = bytearray(draw.randbytes(self.codec.size(message.name)))
        if message.name == "STATE":
            # Else a host that commands would hardly look at the readings.
            payload[0] = draw.choice((DeviceState.ARMED, payload[0]))
        body = head + payload
        return (
            b"\0"
            + stuff(body + struct.pack("<H", crc_hqx(body, 0xFFFF)))
            + b"\0"
        )

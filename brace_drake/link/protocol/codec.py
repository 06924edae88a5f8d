"""Messages to bytes and back, checked at every step.

A frame is 0, COBS(header, payload, CRC-16), 0. The CRC is CRC-16/CCITT-FALSE
(polynomial 0x1021, begun at 0xFFFF). What makes a brace move is sealed as
well: the payload ends with a CRC-32 begun at the session's number, so that
neither a corruption that the CRC-16 lets through, one in 65 536, nor a frame
of an older session is acted upon.
"""

from __future__ import annotations

import struct
import zlib
from binascii import crc_hqx
from collections import namedtuple
from functools import cache
from typing import NamedTuple

from brace_drake.link.protocol.cobs import stuff, unstuff
from brace_drake.link.protocol.messages import (
    BY_NAME,
    HEADER,
    KINDS,
    MESSAGES,
    VERSION,
    Field,
    Message,
    num_items,
)

_HEADER = struct.Struct("<" + "".join(KINDS[f.kind][0] for f in HEADER))
_SEAL_BYTES = 4
# Most stages that a message can be for; it bounds what a receiver keeps.
MAX_STAGES = 3


class Packet(NamedTuple):
    """A message received.

    Attributes:
        name: Of the message.
        sequence: Of its sender.
        time_us: The sender's clock, us.
        values: Its fields by name; arrays are tuples.
        sealed_bytes: What the seal of a sealed message covers.
    """

    name: str
    sequence: int
    time_us: int
    values: tuple
    sealed_bytes: bytes = b""


class _Layout:
    """How one message lies in bytes on a device of so many stages."""

    def __init__(self, message: Message, stages: int):
        self.message = message
        code, at, self.slices, self.texts = "<", 0, [], []
        for field in message.fields:
            number = num_items(field, stages)
            if field.kind == "text":
                code += f"{number}s"
                self.texts.append(len(self.slices))
                number = 1
            else:
                code += KINDS[field.kind][0] * number
            many = number > 1 or _is_array(field)
            self.slices.append(slice(at, at + number) if many else at)
            at += number
        self.struct = struct.Struct(code)
        names = [field.name for field in message.fields]
        self.type = namedtuple(message.name, names)

    def pack(self, values: dict) -> bytes:
        flat: list = []
        for field in self.message.fields:
            value = values[field.name]
            if field.kind == "text":
                flat.append(str(value).encode("ascii", "replace"))
            elif _is_array(field):
                flat.extend(value)
            else:
                flat.append(value)
        return self.struct.pack(*flat)

    def unpack(self, payload: bytes):
        flat = self.struct.unpack(payload)
        values = [flat[s] for s in self.slices]
        for i in self.texts:
            values[i] = values[i].rstrip(b"\0").decode("ascii", "replace")
        return self.type._make(values)


def _is_array(field: Field) -> bool:
    return field.kind != "text" and field.count != (1, 0)


class Codec:
    """Layouts of all messages for a device of so many stages."""

    def __init__(self, stages: int = 1):
        self.stages = stages
        self._layouts = {m.name: _Layout(m, stages) for m in MESSAGES}
        self._by_code = {m.code: self._layouts[m.name] for m in MESSAGES}

    def size(self, name: str) -> int:
        """Bytes of a message's payload."""
        return self._layouts[name].struct.size

    def encode(
        self,
        name: str,
        values: dict,
        sequence: int,
        time_us: int,
        session: int = 0,
    ) -> bytes:
        """A frame, with its delimiters.

        Args:
            name: Of the message.
            values: Its fields; a seal is made here.
            sequence, time_us: Of the header.
            session: What a sealed message is sealed with.

        Raises:
            struct.error: A value does not fit its field.
        """
        message = BY_NAME[name]
        head = _HEADER.pack(VERSION, message.code, sequence & 0xFFFF, time_us)
        if message.sealed:
            values = {**values, "seal": 0}
        body = head + self._layouts[name].pack(values)
        if message.sealed:
            body = body[:-_SEAL_BYTES]
            body += struct.pack("<I", zlib.crc32(body, session))
        body += struct.pack("<H", crc_hqx(body, 0xFFFF))
        return b"\0" + stuff(body) + b"\0"

    def decode(self, chunk: bytes) -> Packet | str:
        """A message from what lies between two delimiters.

        Returns:
            The packet, or in one word why it is none: cobs, short, crc,
            version, type or length.
        """
        body = unstuff(chunk)
        if body is None:
            return "cobs"
        if len(body) < _HEADER.size + 2:
            return "short"
        if crc_hqx(body[:-2], 0xFFFF) != body[-2] | body[-1] << 8:
            return "crc"
        version, code, sequence, time_us = _HEADER.unpack_from(body)
        if version != VERSION:
            return "version"
        layout = self._by_code.get(code)
        if layout is None:
            return "type"
        payload = body[_HEADER.size : -2]
        if len(payload) != layout.struct.size:
            return "length"
        sealed = body[: -2 - _SEAL_BYTES] if layout.message.sealed else b""
        values = layout.unpack(payload)
        return Packet(layout.message.name, sequence, time_us, values, sealed)


@cache
def make_codec(stages: int = 1) -> Codec:
    """The codec of so many stages, made once."""
    return Codec(stages)


def seal_fits(packet: Packet, session: int) -> bool:
    """Whether a sealed message was sealed with this session."""
    return zlib.crc32(packet.sealed_bytes, session) == packet.values.seal


@cache
def longest_frame(stages: int = MAX_STAGES) -> int:
    """Bytes of the longest frame, with its delimiters."""
    codec = make_codec(stages)
    most = max(codec.size(m.name) for m in MESSAGES) + _HEADER.size + 2
    return most + most // 254 + 3


class Decoder:
    """Messages from a stream of bytes that may hold anything.

    What is damaged is counted and left out; the next delimiter begins anew, so
    that damage never costs a whole frame behind it.

    Attributes:
        good: Messages found.
        bad: How many chunks were none, by the word of `Codec.decode`, and
            "long" for more bytes without a delimiter than a frame can have.
        bytes_read: So far.
        follows_hello: Whether a HELLO says how what follows is laid out: on a
            host until it is connected, never on a device.
    """

    REASONS = ("cobs", "short", "crc", "version", "type", "length", "long")

    def __init__(self, codec: Codec, follows_hello: bool = False):
        self._codec, self.follows_hello = codec, follows_hello
        self._longest = longest_frame()
        self._rest = bytearray()
        self._skipping = False
        self.good = 0
        self.bytes_read = 0
        self.bad = dict.fromkeys(self.REASONS, 0)

    @property
    def num_bad(self) -> int:
        """Chunks that were no message."""
        return sum(self.bad.values())

    def feed(self, data: bytes) -> list[Packet]:
        """Messages that end within these bytes, in their order."""
        self.bytes_read += len(data)
        chunks = data.split(b"\0")
        out: list[Packet] = []
        for chunk in chunks[:-1]:
            self._rest += chunk
            self._take(out)
        self._rest += chunks[-1]
        if len(self._rest) > self._longest:
            if not self._skipping:
                self.bad["long"] += 1
            self._skipping = True
            self._rest.clear()
        return out

    def _take(self, out: list[Packet]) -> None:
        chunk = bytes(self._rest)
        self._rest.clear()
        if self._skipping:
            # The tail of what was too long is not a frame of its own.
            self._skipping = False
            return
        if not chunk:
            return
        if len(chunk) > self._longest:
            self.bad["long"] += 1
            return
        found = self._codec.decode(chunk)
        if isinstance(found, str):
            self.bad[found] += 1
            return
        self.good += 1
        out.append(found)
        if self.follows_hello and found.name == "HELLO":
            if 1 <= found.values.stages <= MAX_STAGES:
                self._codec = make_codec(found.values.stages)

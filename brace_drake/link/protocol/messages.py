"""The one definition of the link's messages.

The codec, the tables of PROTOCOL.md and brace_protocol.h are made from it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from brace_drake.link.protocol.limits import SHARED

VERSION = 1
BAUD = 1_000_000
# Kind of a field: struct code, C type, bytes.
KINDS = {
    "u8": ("B", "uint8_t", 1),
    "u16": ("H", "uint16_t", 2),
    "u32": ("I", "uint32_t", 4),
    "u64": ("Q", "uint64_t", 8),
    "f32": ("f", "float", 4),
    "text": ("s", "char", 1),
}
# How many: a number, and so many for each stage.
ONE, EACH, LEGS, FORCES, XYZ, ANCHORS, TEXT = (
    (1, 0),
    (0, 1),
    (0, 6),
    (0, 3),
    (3, 0),
    (0, 18),
    (16, 0),
)


class Field(NamedTuple):
    """A field of a message: kind, meaning, unit, how many, name."""

    kind: str
    meaning: str
    unit: str = ""
    count: tuple[int, int] = ONE
    name: str = ""


class Message(NamedTuple):
    """A message.

    Attributes:
        name: In capitals.
        code: Of its type on the wire.
        sender: host, device or both.
        feeds: What of the device it feeds: nothing, session or watchdog.
        fields: In the order of the wire, without gaps.
        meaning: In a sentence.
    """

    name: str
    code: int
    sender: str
    feeds: str
    fields: tuple[Field, ...]
    meaning: str

    @property
    def sealed(self) -> bool:
        """Whether its last field is a seal, see PROTOCOL.md."""
        return self.fields[-1].name == "seal"


BY_NAME: dict[str, Message] = {}


def _message(
    code: int, sender: str, feeds: str = "nothing"
) -> Callable[[type], Message]:
    """Makes a message of a class: its fields, and its docstring as meaning."""

    def make(body: type) -> Message:
        fields, name = tuple(_named_fields(body)), body.__name__
        meaning = body.__doc__ or ""
        BY_NAME[name] = Message(name, code, sender, feeds, fields, meaning)
        return BY_NAME[name]

    return make


def _named_fields(body: type) -> Iterator[Field]:
    for name, value in vars(body).items():
        if isinstance(value, Field):
            yield value._replace(name=name)
        elif value is _LIMITS:
            yield from value


u8, u16, u32, u64, f32 = (
    partial(Field, kind) for kind in ("u8", "u16", "u32", "u64", "f32")
)
text = partial(Field, "text", count=TEXT)

HEADER = (
    u8("of this protocol", name="version"),
    u8("code of the message", name="type"),
    u16("of this sender, one up with each message", name="sequence"),
    u64("the sender's clock, never back", "us", name="time_us"),
)
_SEAL = u32("CRC-32 of all before it, begun at the session")
_LIMITS = tuple(
    f32(s.meaning, s.unit, EACH if s.by_stage else ONE, s.name) for s in SHARED
)


@_message(0x01, "host")
class HELLO_REQUEST:
    """Asks who is there. Answered in every state but BOOT."""

    nonce = u32("any number")


@_message(0x02, "device")
class HELLO:
    """Says who the device is and what it measures."""

    nonce = u32("of the request")
    model = text("kind of device")
    identity = text("serial number")
    firmware = text("version")
    units = text('"m N s rad"')
    stages = u8("S: S rings move, 6 S legs")
    state = u8("see states")
    capabilities = u8("bit 0: commands of length")
    rate_hz = f32("of ticks, and so of states", "Hz")
    length_resolution = f32("of leg lengths", "m")
    force_resolution = f32("of forces", "N")
    force_range = f32("full scale of forces", "N")


@_message(0x03, "device")
class GEOMETRY:
    """The geometry that the device was calibrated to; follows HELLO."""

    rest = f32("of each ring's origin, W", "m", FORCES)
    lower = f32("lower anchors, lower ring", "m", ANCHORS)
    upper = f32("upper anchors, upper ring", "m", ANCHORS)


@_message(0x04, "device")
class DEVICE_LIMITS:
    """The widest limits that the device accepts; follows GEOMETRY."""

    limits = _LIMITS


@_message(0x05, "host", feeds="session")
class LIMITS:
    """The limits that shall hold; sealed with the session 0."""

    limits = _LIMITS
    seal = _SEAL


@_message(0x06, "device")
class LIMITS_ECHO:
    """The limits that hold now. The host compares them bit by bit."""

    reason = u8("see reasons")
    index = u8("of the refused limit, from 0")
    session = u32("new and not 0; 0 where refused")
    limits = _LIMITS


@_message(0x10, "device")
class STATE:
    """Readings of one tick; sent each tick while there is a session."""

    state = u8("see states")
    cause = u8("see causes")
    flags = u16("see flags")
    tick = u32("counts control ticks, modulo 2^32")
    command = u16("sequence of the command in use")
    rejected = u16("messages refused so far, modulo 2^16")
    leg_length = f32("of each leg", "m", LEGS)
    force = f32("of each ring on the torso, W", "N", FORCES)
    marker = f32("on the torso, from rest, W", "m", XYZ)


@_message(0x11, "host", feeds="watchdog")
class COMMAND:
    """What the legs shall do from this tick on."""

    mode = u8("see modes")
    tick = u32("of the state that it answers")
    values = f32("of each leg", "N or m", LEGS)
    seal = _SEAL


@_message(0x12, "both", feeds="session")
class HEARTBEAT:
    """Keeps the session; the device answers each, for the clocks."""

    echo_us = u64("time_us of the heartbeat answered", "us")


@_message(0x13, "host", feeds="session")
class ARM:
    """Lets the drives follow commands."""

    nonce = u32("any number")
    seal = _SEAL


@_message(0x14, "host", feeds="session")
class DISARM:
    """Releases the drives without a latched stop."""

    nonce = u32("any number")


@_message(0x15, "host", feeds="session")
class STOP:
    """Releases the drives and latches. Needs neither seal nor session."""

    cause = u8("see causes")


@_message(0x16, "host", feeds="session")
class CLEAR:
    """Ends a latched stop where its cause has gone; to DISARMED."""

    cause = u8("the one that was latched")
    seal = _SEAL


@_message(0x17, "device")
class ANSWER:
    """Answers ARM, DISARM, STOP and CLEAR."""

    request = u8("code of the message answered")
    sequence_answered = u16("its sequence")
    reason = u8("see reasons")
    state = u8("after it, see states")


@_message(0x18, "device")
class FAULT:
    """Sent once, when a stop latches."""

    state = u8("STOPPED or FAULT")
    cause = u8("see causes")
    index = u8("of the leg or ring, from 0")
    value = f32("what was measured")
    limit = f32("what is allowed")


MESSAGES = tuple(BY_NAME.values())
# Once one has come, nothing of these that was sent before it counts any more.
ORDERED = ("LIMITS", "COMMAND", "ARM", "CLEAR", "DISARM", "STOP")


def num_items(field: Field, stages: int) -> int:
    """How many numbers a field holds on a device of so many stages."""
    return field.count[0] + field.count[1] * stages

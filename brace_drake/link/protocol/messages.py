"""The one definition of the link's messages.

The codec, the tables of PROTOCOL.md and brace_protocol.h are made from it.
"""

from __future__ import annotations

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
    """A field of a message: name, kind, how many, unit, meaning."""

    name: str
    kind: str
    count: tuple[int, int]
    unit: str
    meaning: str


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
        return self.fields[-1] == _SEAL


def _field(name, kind, meaning, unit="", count=ONE) -> Field:
    return Field(name, kind, count, unit, meaning)


HEADER = (
    _field("version", "u8", "of this protocol"),
    _field("type", "u8", "code of the message"),
    _field("sequence", "u16", "of this sender, one up with each message"),
    _field("time_us", "u64", "the sender's clock, never back", "us"),
)
_SEAL = _field("seal", "u32", "CRC-32 of all before it, begun at the session")
_LIMITS = tuple(
    _field(s.name, "f32", s.meaning, s.unit, EACH if s.by_stage else ONE)
    for s in SHARED
)
_CAUSE = _field("cause", "u8", "see causes")

MESSAGES = (
    Message(
        "HELLO_REQUEST",
        0x01,
        "host",
        "nothing",
        (_field("nonce", "u32", "any number"),),
        "Asks who is there. Answered in every state but BOOT.",
    ),
    Message(
        "HELLO",
        0x02,
        "device",
        "nothing",
        (
            _field("nonce", "u32", "of the request"),
            _field("model", "text", "kind of device", count=TEXT),
            _field("identity", "text", "serial number", count=TEXT),
            _field("firmware", "text", "version", count=TEXT),
            _field("units", "text", '"m N s rad"', count=TEXT),
            _field("stages", "u8", "S: S rings move, 6 S legs"),
            _field("state", "u8", "see states"),
            _field("capabilities", "u8", "bit 0: commands of length"),
            _field("rate_hz", "f32", "of ticks, and so of states", "Hz"),
            _field("length_resolution", "f32", "of leg lengths", "m"),
            _field("force_resolution", "f32", "of forces", "N"),
            _field("force_range", "f32", "full scale of forces", "N"),
        ),
        "Says who the device is and what it measures.",
    ),
    Message(
        "GEOMETRY",
        0x03,
        "device",
        "nothing",
        (
            _field("rest", "f32", "of each ring's origin, W", "m", FORCES),
            _field("lower", "f32", "lower anchors, lower ring", "m", ANCHORS),
            _field("upper", "f32", "upper anchors, upper ring", "m", ANCHORS),
        ),
        "The geometry that the device was calibrated to; follows HELLO.",
    ),
    Message(
        "DEVICE_LIMITS",
        0x04,
        "device",
        "nothing",
        _LIMITS,
        "The widest limits that the device accepts; follows GEOMETRY.",
    ),
    Message(
        "LIMITS",
        0x05,
        "host",
        "session",
        (*_LIMITS, _SEAL),
        "The limits that shall hold; sealed with the session 0.",
    ),
    Message(
        "LIMITS_ECHO",
        0x06,
        "device",
        "nothing",
        (
            _field("reason", "u8", "see reasons"),
            _field("index", "u8", "of the refused limit, from 0"),
            _field("session", "u32", "new and not 0; 0 where refused"),
            *_LIMITS,
        ),
        "The limits that hold now. The host compares them bit by bit.",
    ),
    Message(
        "STATE",
        0x10,
        "device",
        "nothing",
        (
            _field("state", "u8", "see states"),
            _CAUSE,
            _field("flags", "u16", "see flags"),
            _field("tick", "u32", "counts control ticks"),
            _field("command", "u16", "sequence of the command in use"),
            _field("rejected", "u16", "messages refused so far, modulo 2^16"),
            _field("leg_length", "f32", "of each leg", "m", LEGS),
            _field("force", "f32", "of each ring on the torso, W", "N", FORCES),
            _field("marker", "f32", "on the torso, from rest, W", "m", XYZ),
        ),
        "Readings of one tick; sent each tick while there is a session.",
    ),
    Message(
        "COMMAND",
        0x11,
        "host",
        "watchdog",
        (
            _field("mode", "u8", "see modes"),
            _field("tick", "u32", "of the state that it answers"),
            _field("values", "f32", "of each leg", "N or m", LEGS),
            _SEAL,
        ),
        "What the legs shall do from this tick on.",
    ),
    Message(
        "HEARTBEAT",
        0x12,
        "both",
        "session",
        (_field("echo_us", "u64", "time_us of the heartbeat answered", "us"),),
        "Keeps the session; the device answers each, for the clocks.",
    ),
    Message(
        "ARM",
        0x13,
        "host",
        "session",
        (_field("nonce", "u32", "any number"), _SEAL),
        "Lets the drives follow commands.",
    ),
    Message(
        "DISARM",
        0x14,
        "host",
        "session",
        (_field("nonce", "u32", "any number"),),
        "Releases the drives without a latched stop.",
    ),
    Message(
        "STOP",
        0x15,
        "host",
        "session",
        (_CAUSE,),
        "Releases the drives and latches. Needs neither seal nor session.",
    ),
    Message(
        "CLEAR",
        0x16,
        "host",
        "session",
        (_field("cause", "u8", "the one that was latched"), _SEAL),
        "Ends a latched stop where its cause has gone; to DISARMED.",
    ),
    Message(
        "ANSWER",
        0x17,
        "device",
        "nothing",
        (
            _field("request", "u8", "code of the message answered"),
            _field("sequence_answered", "u16", "its sequence"),
            _field("reason", "u8", "see reasons"),
            _field("state", "u8", "after it, see states"),
        ),
        "Answers ARM, DISARM, STOP and CLEAR.",
    ),
    Message(
        "FAULT",
        0x18,
        "device",
        "nothing",
        (
            _field("state", "u8", "STOPPED or FAULT"),
            _CAUSE,
            _field("index", "u8", "of the leg or ring, from 0"),
            _field("value", "f32", "what was measured"),
            _field("limit", "f32", "what is allowed"),
        ),
        "Sent once, when a stop latches.",
    ),
)
BY_NAME = {message.name: message for message in MESSAGES}


def num_items(field: Field, stages: int) -> int:
    """How many numbers a field holds on a device of so many stages."""
    return field.count[0] + field.count[1] * stages

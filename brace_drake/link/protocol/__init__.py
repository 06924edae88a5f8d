"""What is said on the line: limits, words, messages, and their bytes.

Limits are declared in `limits`, states and causes in `words`, messages in
`messages`; the codec, the tables of PROTOCOL.md and brace_protocol.h follow
from them (tools/write_protocol.py). Nothing here opens a port or keeps time.
"""

from brace_drake.link.protocol.codec import Codec, Decoder, Packet, make_codec
from brace_drake.link.protocol.limits import DEFAULT, LIMITS, SHARED, Limits
from brace_drake.link.protocol.messages import BAUD, MESSAGES, VERSION
from brace_drake.link.protocol.words import (
    Cause,
    DeviceState,
    Mode,
    Reason,
    StateFlag,
)

__all__ = [
    "BAUD",
    "DEFAULT",
    "LIMITS",
    "MESSAGES",
    "SHARED",
    "VERSION",
    "Cause",
    "Codec",
    "Decoder",
    "DeviceState",
    "Limits",
    "Mode",
    "Packet",
    "Reason",
    "StateFlag",
    "make_codec",
]

"""Numbers with a name that travel in messages: states, causes, flags."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple


class Word(IntEnum):
    """A number with a name.

    Attributes:
        meaning: In a few words.
    """

    meaning: str

    def __new__(cls, number: int, meaning: str):
        word = int.__new__(cls, number)
        word._value_, word.meaning = number, meaning
        return word

    @property
    def text(self) -> str:
        """The name in words, such as "leg stroke"."""
        return self.name.lower().replace("_", " ")


class DeviceState(Word):
    """Where the device's state machine is."""

    BOOT = 0, "self-test; silent, but for noise; drives released"
    HELLO = 1, "waits for a host's hello and limits; drives released"
    DISARMED = 2, "limits agreed, states are sent; drives released"
    ARMED = 3, "follows commands; the watchdog runs"
    STOPPED = 4, "latched stop with its cause; drives released"
    FAULT = 5, "e-stop or drive fault; drives without power"


class Transition(NamedTuple):
    """A way from some states to another: on a message, or within a tick."""

    before: tuple[DeviceState, ...]
    after: DeviceState
    on: str
    when: str = "accepted"


_BOOT, _HELLO, _DISARMED, _ARMED, _STOPPED, _FAULT = DeviceState
TICK = "TICK"
# No device goes any other way.
TRANSITIONS = (
    Transition((_BOOT,), _HELLO, TICK, "self-test passed"),
    Transition((_BOOT,), _FAULT, TICK, "self-test failed"),
    Transition((_HELLO,), _DISARMED, "LIMITS"),
    Transition((_DISARMED,), _HELLO, TICK, "session ran out"),
    Transition(
        (_DISARMED,), _ARMED, "ARM", "sealed, newer, readings within limits"
    ),
    Transition((_ARMED,), _DISARMED, "DISARM"),
    Transition((_ARMED,), _STOPPED, TICK, "watchdog, a limit passed"),
    Transition(
        (_ARMED,), _STOPPED, "COMMAND", "sealed, newer, no finite number"
    ),
    Transition((_HELLO, _DISARMED, _ARMED), _STOPPED, "STOP"),
    Transition(
        (_STOPPED, _FAULT),
        _DISARMED,
        "CLEAR",
        "sealed, newer, of the latched cause, which is gone",
    ),
    Transition(
        (_HELLO, _DISARMED, _ARMED, _STOPPED),
        _FAULT,
        TICK,
        "e-stop, drive fault",
    ),
)


class Cause(Word):
    """Why a stop was made; it stays until it is cleared."""

    NONE = 0, "none"
    HOST_STOP = 1, "the host sent a stop"
    STOP_KEY = 2, "the operator's stop key"
    WATCHDOG = 3, "no accepted command within the watchdog's period"
    ESTOP = 4, "the emergency stop is pressed"
    DRIVE_FAULT = 5, "a drive reports a fault"
    LEG_STROKE = 6, "a leg is shorter or longer than allowed"
    LEG_SPEED = 7, "a leg is faster than allowed"
    PAD_FORCE = 8, "the force of a pad is above its limit"
    TOTAL_FORCE = 9, "the sum of the rings' forces is above its limit"
    RING_POSE = 10, "a ring is displaced or turned further than allowed"
    TRACKING = 11, "a ring is further from its virtual pose than allowed"
    STALE_DATA = 12, "the newest reading is older than allowed"
    LOST_MESSAGES = 13, "more messages in a row are lost than allowed"
    JUMP = 14, "a reading changes from one tick to the next as none can"
    DISAGREEMENT = 15, "force reading and leg forces disagree for too long"
    STUCK_LEG = 16, "a leg's reading stands still while others travel"
    BAD_COMMAND = 17, "a command holds a value that is no finite number"
    NO_POSE = 18, "no ring pose fits the leg lengths"
    DISCONNECTED = 19, "the port is gone"
    HOST_ERROR = 20, "the host's control law failed"
    DISARMED = 21, "the device left ARMED, and its host had not asked for it"


class StateFlag(IntFlag):
    """Bits of the `flags` of a state."""

    meaning: str

    def __new__(cls, number: int, meaning: str):
        flag = int.__new__(cls, number)
        flag._value_, flag.meaning = number, meaning
        return flag

    CLAMPED = 1, "the command was cut at a limit of force or rate"
    ESTOP = 2, "the emergency stop is pressed now"
    MARKER = 4, "`marker` holds a measurement"
    NO_NEW_COMMAND = 8, "the last tick began without a new command"
    RELEASING = 16, "the release has not ended yet"


class Mode(Word):
    """What a command's values are."""

    FORCE = 0, "leg forces, N; positive pushes the anchors apart"
    LENGTH = 1, "leg lengths, m; optional, see `capabilities` of hello"


class Reason(Word):
    """Why a request was refused."""

    ACCEPTED = 0, "the request was carried out"
    WRONG_STATE = 1, "not in this state"
    WRONG_SESSION = 2, "sealed for another session"
    ESTOP_PRESSED = 3, "the emergency stop is pressed"
    CAUSE_PRESENT = 4, "what made the stop is still there"
    LIMIT_TOO_WIDE = 5, "a limit is wider than the device's own"
    BAD_VALUE = 6, "a value is no finite number, or makes no sense"
    NOT_SUPPORTED = 7, "the device cannot do that"
    REPLAYED = 8, "not newer than what has come in this session"


def cause_name(number: int) -> str:
    """A cause in words, such as "leg stroke"; unknown ones by number."""
    known = number in set(map(int, Cause))
    return Cause(number).text if known else f"cause {number}"


def reason_text(number: int) -> str:
    """Why a request was refused, in words; unknown reasons by number."""
    known = number in set(map(int, Reason))
    return Reason(number).meaning if known else f"reason {number}"

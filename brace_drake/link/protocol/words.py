"""Numbers with a name that travel in messages: states, causes, flags."""

from __future__ import annotations

from enum import IntEnum, IntFlag


class DeviceState(IntEnum):
    """Where the device's state machine is."""

    BOOT = 0
    HELLO = 1
    DISARMED = 2
    ARMED = 3
    STOPPED = 4
    FAULT = 5


class Cause(IntEnum):
    """Why a stop was made; it stays until it is cleared."""

    NONE = 0
    HOST_STOP = 1
    STOP_KEY = 2
    WATCHDOG = 3
    ESTOP = 4
    DRIVE_FAULT = 5
    LEG_STROKE = 6
    LEG_SPEED = 7
    PAD_FORCE = 8
    TOTAL_FORCE = 9
    RING_POSE = 10
    TRACKING = 11
    STALE_DATA = 12
    LOST_MESSAGES = 13
    JUMP = 14
    DISAGREEMENT = 15
    STUCK_LEG = 16
    BAD_COMMAND = 17
    NO_POSE = 18
    DISCONNECTED = 19
    HOST_ERROR = 20


class StateFlag(IntFlag):
    """Bits of the `flags` of a state."""

    NONE = 0
    CLAMPED = 1
    ESTOP = 2
    MARKER = 4
    NO_NEW_COMMAND = 8
    RELEASING = 16


class Mode(IntEnum):
    """What a command's values are."""

    FORCE = 0
    LENGTH = 1


class Reason(IntEnum):
    """Why a request was refused."""

    ACCEPTED = 0
    WRONG_STATE = 1
    WRONG_SESSION = 2
    ESTOP_PRESSED = 3
    CAUSE_PRESENT = 4
    LIMIT_TOO_WIDE = 5
    BAD_VALUE = 6
    NOT_SUPPORTED = 7


_MEANINGS = (
    (DeviceState.BOOT, "self-test; silent, but for noise; drives released"),
    (DeviceState.HELLO, "waits for a host's hello and limits; drives released"),
    (DeviceState.DISARMED, "limits agreed, states are sent; drives released"),
    (DeviceState.ARMED, "follows commands; the watchdog runs"),
    (DeviceState.STOPPED, "latched stop with its cause; drives released"),
    (DeviceState.FAULT, "e-stop or drive fault; drives without power"),
    (Cause.NONE, "none"),
    (Cause.HOST_STOP, "the host sent a stop"),
    (Cause.STOP_KEY, "the operator's stop key"),
    (Cause.WATCHDOG, "no accepted command within the watchdog's period"),
    (Cause.ESTOP, "the emergency stop is pressed"),
    (Cause.DRIVE_FAULT, "a drive reports a fault"),
    (Cause.LEG_STROKE, "a leg is shorter or longer than allowed"),
    (Cause.LEG_SPEED, "a leg is faster than allowed"),
    (Cause.PAD_FORCE, "the force of a pad is above its limit"),
    (Cause.TOTAL_FORCE, "the sum of the rings' forces is above its limit"),
    (Cause.RING_POSE, "a ring is displaced or turned further than allowed"),
    (Cause.TRACKING, "a ring is further from its virtual pose than allowed"),
    (Cause.STALE_DATA, "the newest reading is older than allowed"),
    (Cause.LOST_MESSAGES, "more messages in a row are lost than allowed"),
    (Cause.JUMP, "a reading changes from one tick to the next as none can"),
    (Cause.DISAGREEMENT, "force reading and leg forces disagree for too long"),
    (Cause.STUCK_LEG, "a leg's reading stands still while others travel"),
    (Cause.BAD_COMMAND, "a command holds a value that is no finite number"),
    (Cause.NO_POSE, "no ring pose fits the leg lengths"),
    (Cause.DISCONNECTED, "the port is gone"),
    (Cause.HOST_ERROR, "the host's control law failed"),
    (StateFlag.CLAMPED, "the command was cut at a limit of force or rate"),
    (StateFlag.ESTOP, "the emergency stop is pressed now"),
    (StateFlag.MARKER, "`marker` holds a measurement"),
    (StateFlag.NO_NEW_COMMAND, "the last tick began without a new command"),
    (StateFlag.RELEASING, "the release has not ended yet"),
    (Mode.FORCE, "leg forces, N; positive pushes the anchors apart"),
    (Mode.LENGTH, "leg lengths, m; optional, see `capabilities` of hello"),
    (Reason.ACCEPTED, "the request was carried out"),
    (Reason.WRONG_STATE, "not in this state"),
    (Reason.WRONG_SESSION, "sealed for another session"),
    (Reason.ESTOP_PRESSED, "the emergency stop is pressed"),
    (Reason.CAUSE_PRESENT, "what made the stop is still there"),
    (Reason.LIMIT_TOO_WIDE, "a limit is wider than the device's own"),
    (Reason.BAD_VALUE, "a value is no finite number, or makes no sense"),
    (Reason.NOT_SUPPORTED, "the device cannot do that"),
)
# Words of different kinds are equal where their numbers are: the kind counts.
MEANINGS = {(type(word), word): meaning for word, meaning in _MEANINGS}


def meaning_of(word: IntEnum | IntFlag) -> str:
    """What a word says, in a few words."""
    return MEANINGS[type(word), word]


def cause_name(number: int) -> str:
    """A cause in words, such as "leg stroke"; unknown ones by number."""
    try:
        return Cause(number).name.lower().replace("_", " ")
    except ValueError:
        return f"cause {number}"


def reason_text(number: int) -> str:
    """Why a request was refused, in words; unknown reasons by number."""
    try:
        return meaning_of(Reason(number))
    except ValueError:
        return f"reason {number}"

"""What a sequence of numbered messages tells: lost, repeated, overtaken."""

from __future__ import annotations

from typing import NamedTuple

# Messages farther apart than this are told by their clocks alone, us.
SOON_US = 10_000_000


def steps_ahead(number: int, other: int, bits: int = 16) -> int:
    """How far a number that goes round at 2^bits is in front of another.

    Half a turn at most; below 0 where it is behind.
    """
    half = 1 << bits - 1
    return (number - other + half) % (2 * half) - half


def is_newer(sequence: int, time_us: int, newest: tuple[int, int]) -> bool:
    """Whether a message was sent after the newest one that has come.

    A sequence goes round: of messages that are far apart only the sender's
    clock tells which is newer. PROTOCOL.md, "Newer".

    Args:
        sequence, time_us: Of the message.
        newest: Sequence and clock, us, of the newest so far.
    """
    later = time_us - newest[1]
    ahead = steps_ahead(sequence, newest[0])
    return later > SOON_US or (later >= 0 and ahead > 0)


class Counts(NamedTuple):
    """What has come in so far.

    Attributes:
        messages: Good ones, once each and in order.
        states: Of these, states.
        bad: Chunks of bytes that were no message.
        lost: Missing in their place, by their sequence; late ones too.
        repeated: Those that came again.
        late: Those that another had overtaken; not used.
        bytes_read: Altogether.
    """

    messages: int
    states: int
    bad: int
    lost: int
    repeated: int
    late: int
    bytes_read: int


# A number so far ahead is believed once the next one follows it: more likely
# than so many lost messages is damage that the checksum has missed.
_LEAP = 100


class SequenceWatch:
    """Counts of one sender's messages, by numbers modulo 2^16.

    A message that leaps ahead is not used, unless it goes on from there (as RFC
    3550, A.1, does it): one wrong number must not make all that follow it old.

    Attributes:
        lost: Missing in their place; those that came late included.
        repeated: Come again.
        late: Come after one that was sent behind them.
    """

    def __init__(self):
        self._last: int | None = None
        self._after_leap: int | None = None
        self.lost = self.repeated = self.late = 0

    def take(self, sequence: int, begins: bool = False) -> int | None:
        """Takes the next number that came.

        Args:
            sequence: Of the message.
            begins: Whether the sender may have begun anew with it.

        Returns:
            How many are missing in front of it; None where the message is old
            and not to be used.
        """
        last = self._last
        if last is None or begins:
            self._last = sequence
            return 0
        ahead = steps_ahead(sequence, last)
        after_leap, self._after_leap = self._after_leap, None
        if ahead > _LEAP and sequence != after_leap:
            self._after_leap = (sequence + 1) & 0xFFFF
            return None
        if ahead > 0:
            self._last = sequence
            self.lost += ahead - 1
            return ahead - 1
        if ahead == 0:
            self.repeated += 1
        else:
            self.late += 1
        return None

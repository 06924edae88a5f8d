"""The operator's console: a stop key, a countdown, one line of status."""

from __future__ import annotations

import contextlib
import select
import sys
import time
from collections.abc import Iterator

from brace_drake.core.errors import StoppedError

STOP_KEYS = "any key stops"


class Keys:
    """Single keys of a terminal, none where there is no terminal."""

    def __init__(self):
        self.is_terminal = sys.stdin is not None and sys.stdin.isatty()

    def pressed(self) -> bool:
        """Whether a key was pressed since the last call."""
        if not self.is_terminal:
            return False
        ready, _, _ = select.select([sys.stdin], [], [], 0.0)
        if ready:
            sys.stdin.read(1)
        return bool(ready)


@contextlib.contextmanager
def ReadKeys() -> Iterator[Keys]:
    """Keys without waiting for the end of a line, as long as it lasts."""
    keys = Keys()
    if not keys.is_terminal:
        yield keys
        return
    import termios
    import tty

    before = termios.tcgetattr(sys.stdin)
    try:
        tty.setcbreak(sys.stdin)
        yield keys
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def CountDown(seconds: int, name: str, keys: Keys, more: str = "") -> None:
    """Counts down to a motion, of which there may be `more` to say.

    Raises:
        StoppedError: A key was pressed instead of waiting.
    """
    for left in range(seconds, 0, -1):
        Say(f"{name}{more} moves in {left} s ({STOP_KEYS})")
        ends = time.monotonic() + 1.0
        while time.monotonic() < ends:
            if keys.pressed():
                raise StoppedError(f"{name}: not begun")
            time.sleep(0.02)


def Say(text: str, end: bool = False) -> None:
    """Replaces the line of status on a terminal; else prints what ends."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{text}", end="\n" if end else "", file=sys.stderr)
        sys.stderr.flush()
    elif end:
        print(text, file=sys.stderr, flush=True)


def describe_status(share: float, session) -> str:
    """A bar, and what the line does."""
    done = round(30 * min(1.0, share))
    tally = session.tally
    return (
        f"[{'#' * done}{'.' * (30 - done)}] {100 * share:3.0f} %"
        f"  unanswered {tally.unanswered}, bridged {tally.bridged},"
        f" slowest answer {1e3 * tally.latencies.largest:.1f} ms  ({STOP_KEYS})"
    )

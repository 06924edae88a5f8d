"""A line that does to bytes what lines do: on demand, and by a seed."""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass, fields

from brace_drake.core.errors import LinkError

# Frames on their way: more than a host sends in the longest delay.
_MOST_QUEUED = 20_000


@dataclass
class LineFaults:
    """Shares of frames, from 0 to 1, and a delay.

    Attributes:
        drop: Lost.
        corrupt: With 1 to 8 of their bytes changed.
        truncate: Cut off at some byte.
        duplicate: Sent twice.
        reorder: Held back behind the next frame.
        delay: Of every frame, s.
    """

    drop: float = 0.0
    corrupt: float = 0.0
    truncate: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    delay: float = 0.0

    def set(self, name: str, value: float) -> None:
        """Sets one by name.

        Raises:
            LinkError: No such fault, or no such value.
        """
        names = [f.name for f in fields(self)]
        if name not in names:
            raise LinkError(
                f"no line fault {name!r}; there are {', '.join(names)}"
            )
        most = 10.0 if name == "delay" else 1.0
        if not 0.0 <= value <= most:
            raise LinkError(
                f"line fault {name} is {value:g}; allowed: 0 to {most:g}"
            )
        setattr(self, name, value)


class Line:
    """One direction of a line: frames in, bytes out when their time has come.

    Attributes:
        faults: May be changed at any time.
        damaged: Frames that did not pass whole, once and in order.
    """

    def __init__(self, faults: LineFaults | None = None, seed: int = 0):
        self.faults = faults or LineFaults()
        self.damaged = 0
        self._draw = random.Random(seed)
        self._queue: list[tuple[float, int, bytes]] = []
        self._number = 0
        self._held: bytes | None = None

    def send(self, frame: bytes, now: float) -> None:
        """Takes a frame at a time, s; a full line loses it."""
        if len(self._queue) >= _MOST_QUEUED:
            return
        for piece in self._spoil(frame):
            self._number += 1
            due = now + self.faults.delay
            heapq.heappush(self._queue, (due, self._number, piece))

    def take(self, now: float) -> bytes:
        """Bytes that have arrived by now."""
        out = b""
        while self._queue and self._queue[0][0] <= now:
            out += heapq.heappop(self._queue)[2]
        return out

    @property
    def next_due(self) -> float | None:
        """When the next bytes arrive, s; None where none are on their way."""
        return self._queue[0][0] if self._queue else None

    def _spoil(self, frame: bytes) -> list[bytes]:
        faults, chance = self.faults, self._draw.random
        before = self._held
        self._held = None
        out = [frame]
        if faults.drop and chance() < faults.drop:
            out = []
        elif faults.truncate and chance() < faults.truncate:
            out = [frame[: self._draw.randrange(len(frame))]]
        elif faults.corrupt and chance() < faults.corrupt:
            out = [self._corrupt(frame)]
        elif faults.duplicate and chance() < faults.duplicate:
            out = [frame, frame]
        elif faults.reorder and before is None and chance() < faults.reorder:
            self._held, out = frame, []
        if out != [frame]:
            self.damaged += 1
        return out if before is None else [*out, before]

    def _corrupt(self, frame: bytes) -> bytes:
        data = bytearray(frame)
        for _ in range(self._draw.randint(1, 8)):
            data[self._draw.randrange(len(data))] ^= self._draw.randint(1, 255)
        return bytes(data)

"""The device's clock as the host's sees it, from echoed heartbeats.

A heartbeat sent at a, stamped by the device with d, and back at b says that the
device's clock was d at (a + b) / 2, wrong by at most (b - a) / 2. Of each
stretch of time the one with the shortest round trip counts (Mills, RFC 5905,
clock filter); rate and offset are the line through those.
"""

from __future__ import annotations

from collections import deque

_STRETCH = 1.0
_KEPT = 60


class ClockSync:
    """Offset and rate of a device's clock against the host's, s.

    Attributes:
        round_trip: The shortest of late, s; None before the first echo.
    """

    def __init__(self):
        self._best: deque[tuple[float, float, float]] = deque(maxlen=_KEPT)
        self._stretch = None
        self.round_trip: float | None = None

    def add(self, sent: float, device: float, received: float) -> None:
        """Takes one echo: host's times, s, and the device's in between."""
        trip, middle = received - sent, 0.5 * (sent + received)
        # An echo later than a stretch tells nothing, and is most likely none.
        if not 0.0 <= trip <= _STRETCH:
            return
        stretch = int(middle / _STRETCH)
        sample = (trip, middle, device - middle)
        if stretch != self._stretch or not self._best:
            self._best.append(sample)
            self._stretch = stretch
        elif trip < self._best[-1][0]:
            self._best[-1] = sample
        self.round_trip = min(sample[0] for sample in self._best)

    @property
    def error_bound(self) -> float | None:
        """How far off the clock can be, s."""
        return None if self.round_trip is None else 0.5 * self.round_trip

    def _line(self) -> tuple[float, float, float]:
        """Time, offset there, and drift, of the line through the samples."""
        n = len(self._best)
        t = sum(s[1] for s in self._best) / n
        o = sum(s[2] for s in self._best) / n
        spread = sum((s[1] - t) ** 2 for s in self._best)
        if n < 3 or spread < _STRETCH**2:
            shortest = min(self._best)
            return shortest[1], shortest[2], 0.0
        drift = sum((s[1] - t) * (s[2] - o) for s in self._best) / spread
        return t, o, drift

    @property
    def drift(self) -> float:
        """How much faster the device's clock runs, s/s."""
        return self._line()[2] if self._best else 0.0

    def host_time(self, device: float) -> float | None:
        """The host's time at a time of the device, s; None before an echo."""
        if not self._best:
            return None
        t, offset, drift = self._line()
        return t + (device - offset - t) / (1.0 + drift)

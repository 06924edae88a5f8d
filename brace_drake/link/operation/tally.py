"""What the line did during a motion, in a room that does not grow."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

# A step of the logarithmic bins, and the smallest value told apart.
_STEP, _LEAST = 0.01, 1e-6
_BINS = 1900


class Spread:
    """Counts of values above 0 in bins of 1 %, from 1e-6 to above 1e2.

    Attributes:
        number: Of values so far.
        total, largest: Their sum and their maximum.
    """

    def __init__(self):
        self.number, self.total, self.largest = 0, 0.0, 0.0
        self._counts = [0] * _BINS

    def Add(self, value: float) -> None:
        """Counts a value."""
        self.number += 1
        self.total += value
        self.largest = max(self.largest, value)
        place = math.log(max(value, _LEAST) / _LEAST) / _STEP
        self._counts[min(_BINS - 1, int(place))] += 1

    @property
    def mean(self) -> float:
        """Of all values; 0 before the first."""
        return self.total / self.number if self.number else 0.0

    def percentiles(
        self, levels=(50.0, 99.0, 99.9), scale: float = 1.0
    ) -> list[float]:
        """Values below which so many of 100 lie, to 1 %; [] before the first.

        The last is never above the largest; all are multiplied with `scale`.
        """
        if self.number == 0:
            return []
        ranks = np.multiply(levels, self.number / 100.0)
        places = np.searchsorted(np.cumsum(self._counts), ranks)
        middles = _LEAST * np.exp(_STEP * (places + 0.5))
        return (scale * np.minimum(middles, self.largest)).tolist()


@dataclass
class Tally:
    """What was seen of the line during a motion.

    Attributes:
        ticks, bridged: Ticks controlled, and of them those interpolated.
        unanswered: Ticks in which the device had no new command in time.
        periods, latencies, ages: s, s, ticks.
    """

    ticks: int = 0
    bridged: int = 0
    unanswered: int = 0
    periods: Spread = field(default_factory=Spread)
    latencies: Spread = field(default_factory=Spread)
    ages: Spread = field(default_factory=Spread)

    def describe(self) -> dict:
        """How well the time was kept: counts, and 50, 99, 99.9 %."""
        mean = self.periods.mean
        return {
            "ticks": self.ticks,
            "rate_hz": 1.0 / mean if mean > 0.0 else 0.0,
            "unanswered": self.unanswered,
            "bridged": self.bridged,
            "latency_us": self.latencies.percentiles(scale=1e6),
            "period_us": self.periods.percentiles(scale=1e6),
            "age_ticks": self.ages.percentiles(),
        }

    def __str__(self) -> str:
        said = self.describe()
        three = {
            name: " / ".join(f"{v:.0f}" for v in values)
            for name, values in said.items()
            if isinstance(values, list)
        }
        return (
            f"{self.ticks} ticks at {said['rate_hz']:.0f} Hz;"
            f" answers {three['latency_us']} us,"
            f" periods {three['period_us']} us,"
            f" ages {three['age_ticks']} ticks (50, 99, 99.9 %);"
            f" unanswered {self.unanswered}, bridged {self.bridged}"
        )

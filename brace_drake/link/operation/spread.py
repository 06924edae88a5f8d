"""How values are spread, in a room that does not grow."""

from __future__ import annotations

import math

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

    def percentiles(self, levels=(50.0, 99.0, 99.9)) -> list[float]:
        """Values below which so many of 100 lie, to 1 %; [] before the first.

        The last is never above the largest.
        """
        if self.number == 0:
            return []
        cumulative = np.cumsum(self._counts)
        places = [
            int(np.searchsorted(cumulative, level / 100.0 * self.number))
            for level in levels
        ]
        middles = (_LEAST * math.exp(_STEP * (p + 0.5)) for p in places)
        return [min(value, self.largest) for value in middles]

"""Differences of a machine and its twin, watched sample by sample.

A motion is repeated in cycles. What machine and twin differ by in the first of
them is usual: the subject's numbers, tolerances, and whatever else was there
from the beginning. From then on the whitened difference less the usual one is
noise of variance 1 + 1 / n after n usual cycles, unless something has changed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.monitoring.detector import (
    Thresholds,
    calc_excess,
    estimate_onset,
)
from brace_drake.monitoring.noise_model import NoiseModel

# After an onset so long is looked at, s: more tells little, and takes longer.
LONGEST = 20.0
# What was not as expected has gone after a cycle without it, at least s.
_GONE = 20.0


@dataclass(frozen=True)
class Since:
    """What is known of a change.

    Attributes:
        start: Sample at which the cycle of the onset began, at rest.
        onset: Sample of the onset; both from the beginning of the watch.
        rows: Differences from the onset on, less the usual ones (N, C).
    """

    start: int
    onset: int
    rows: np.ndarray


class Watch:
    """Says since when a machine is not as expected.

    Attributes:
        count: Samples so far.
        onset: Sample since which it is not as expected; None: it is.
        alarm: Sample at which that was told.
        excess: Largest test now, 1 at its threshold; 0 while cycles are usual.
        differs: Whether what is usual is more than the twin's noise.
    """

    def __init__(
        self,
        model: NoiseModel,
        thresholds: Thresholds,
        rate: float,
        cycle: int,
        usual: int = 1,
        readings: slice = slice(None),
    ):
        """Begins at the beginning of a cycle.

        Args:
            model: Of the noise of the readings.
            thresholds: Of the tests.
            rate: Of the samples, Hz.
            cycle: Samples of a cycle.
            usual: How many cycles are usual; 0: the twin is expected.
            readings: Which of the channels are the readings.
        """
        self._model, self._thresholds, self._rate = model, thresholds, rate
        self._cycle, self._usual, self._readings = cycle, usual, readings
        self._longest = round(LONGEST * rate)
        self._gone = max(cycle, round(_GONE * rate))
        self._memory = np.zeros((0, 0))
        self._means: np.ndarray | None = None
        self._whitened_means: np.ndarray | None = None
        self._raw: list[np.ndarray] = []
        self._whitened: list[np.ndarray] = []
        self._last_excess = 0
        self.count, self.excess, self.differs = 0, 0.0, False
        self.onset: int | None = None
        self.alarm: int | None = None

    @property
    def is_learning(self) -> bool:
        """Whether what comes now is taken as usual."""
        return self.count < self._usual * self._cycle

    def Take(self, row: np.ndarray) -> None:
        """Takes the difference at a sample (C,)."""
        reading = row[None, self._readings]
        white = self._model.whiten(reading, self._memory)[0]
        longest = self._model.lags[-1]
        self._memory = np.concatenate(
            [self._memory[-(longest - 1) :].reshape(-1, reading.shape[1]),
             reading]
        )  # fmt: skip
        if self.is_learning:
            self._Learn(row, white)
        elif self._usual:
            at = self.count % self._cycle
            row = row - self._means[at]
            white = white - self._whitened_means[at]
            white = white / np.sqrt(1.0 + 1.0 / self._usual)
        self._raw.append(row)
        self._whitened.append(white)
        self.count += 1
        if self.count == self._usual * self._cycle:
            self._whitened = []
        if self.count % self._thresholds.every == 0:
            self._Look()
        if self.onset is None and self.count % self._cycle == 0:
            del self._raw[: -self._cycle]

    def _Learn(self, row: np.ndarray, white: np.ndarray) -> None:
        if self._means is None:
            self._means = np.zeros((self._cycle, len(row)))
            self._whitened_means = np.zeros((self._cycle, len(white)))
        at = self.count % self._cycle
        self._means[at] += row / self._usual
        self._whitened_means[at] += white / self._usual

    def _Look(self) -> None:
        del self._whitened[: -self._longest]
        recent = np.array(self._whitened[-self._thresholds.samples[-1] :])
        excess = calc_excess(recent, self._thresholds) if len(recent) else 0.0
        if self.is_learning:
            self.differs |= excess > 1.0
            return
        self.excess = excess
        if excess > 1.0:
            self._last_excess = self.count
            if self.onset is None:
                series = np.array(self._whitened)
                back = len(series) - estimate_onset(series, self._rate)
                self.onset, self.alarm = self.count - back, self.count
        elif self.count - self._last_excess > self._gone:
            self.onset = self.alarm = None

    def since(self) -> Since | None:
        """What is known since the onset, of its first `LONGEST` s; None where
        all is as expected.
        """
        if self.onset is None:
            return None
        first = self.count - len(self._raw)
        begin = self.onset - first
        rows = self._raw[begin : begin + self._longest]
        start = self.onset // self._cycle * self._cycle
        return Since(start, self.onset, np.array(rows))

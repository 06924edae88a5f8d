"""The imposed path of a pad as the twin takes it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brace_drake.laws.alone.pad_path import (
    filter_cosines,
    noise_gain,
    path_slopes,
    reach_of,
)


@dataclass(frozen=True)
class PadMotion:
    """Where a pad is asked to be.

    Attributes:
        time: Sample times from 0 (N,), s.
        displacement: As recorded (N,), m.
        sigma: Noise of a displacement reading, m.
        pass_band: Of the light smoothing, see `noise_gain` (N,).
    """

    time: np.ndarray
    displacement: np.ndarray
    sigma: float
    pass_band: np.ndarray

    def path(
        self, noise: np.ndarray | None = None, share: float = 0.0
    ) -> np.ndarray:
        """Displacement, m, and rate, m/s, at the samples (N, 2).

        A cubic Hermite through them is the path. It follows corners without
        the swings of a spline with continuous curvature.

        Args:
            noise: Of the readings (N,), m: what of it smoothing leaves unknown
                is added.
            share: Of the jump of a corner on a sample, what its rate has over
                the mean of both sides, -1/2 to 1/2.
        """
        if noise is None:
            smooth, rate, jumps = self._recorded
        else:
            unknown = filter_cosines(noise, np.sqrt(self.pass_band))
            smooth, rate, jumps = self._sloped(self._recorded[0] + unknown)
        return np.column_stack([smooth, rate + share * jumps])

    @property
    def jumps(self) -> np.ndarray:
        """Of the rate at corners on samples, 0 elsewhere (N,), m/s."""
        return self._recorded[2]

    @property
    def reach(self) -> float:
        """Samples over which the smoothing takes a mean; 0 without any."""
        return reach_of(self.pass_band)

    @cached_property
    def _recorded(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._sloped(filter_cosines(self.displacement, self.pass_band))

    def _sloped(self, smooth: np.ndarray):
        """A smooth displacement, its rate, and jumps of that, each (N,)."""
        return smooth, *path_slopes(self.time, smooth, self.sigma)


def MakePadMotion(
    time: np.ndarray, displacement: np.ndarray, sigma: float
) -> PadMotion:
    """The motion of recorded times (N,), s, and displacements (N,), m.

    Args:
        time, displacement: (N,), s and m.
        sigma: Noise of a displacement reading, m.
    """
    displacement = np.array(displacement, dtype=float)
    gain = noise_gain(displacement, sigma)
    return PadMotion(time - time[0], displacement, sigma, gain)

"""What a recorded run imposes on an axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from brace_drake.devices.pad_bench.motion import MakePadMotion, PadMotion
from brace_drake.recording.jumps import jumps_in
from brace_drake.recording.recording import Run

# Samples at each end whose acceleration is known from one side alone.
_ENDS = 2
# Samples to each side that an acceleration is made of, beside those of the
# smoothing, of which so many reaches count.
_BESIDE, _REACHES = 3, 2
# Bends of an acceleration that are no more than usual, in medians: over samples
# that move by so much of the mean speed, or over those around, as what is
# smooth bends much the same there.
_USUAL, _MOVES, _AROUND = 4.0, 0.1, 31


@dataclass(frozen=True)
class AxisMotion:
    """An imposed motion and what was measured beside it.

    Attributes:
        way: Position as recorded, and its smoothing.
        inputs: Extra inputs (N, J).
    """

    way: PadMotion
    inputs: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Sample times from 0 (N,), s."""
        return self.way.time

    def path(self, noise: np.ndarray | None = None) -> np.ndarray:
        """Position, rate and acceleration at the samples (N, 3), SI.

        Args:
            noise: Added to the recorded position (N,).
        """
        path = self.way.path(noise)
        acceleration = np.gradient(path[:, 1], self.time, edge_order=2)
        return np.column_stack([path, acceleration])

    def trust(self, mass: float, noise: float) -> np.ndarray:
        """Weight of each sample, 0 to 1 (N,): forces are only known where the
        motion is.

        Smoothing knows little of the ends of a record. At a corner of the path
        the acceleration may be anything: where it bends by more than elsewhere
        it is in doubt by as much, and the force by the mass times that.

        Args:
            mass: Of the machine at most, kg or kg m^2.
            noise: Standard deviation of a force reading, N or N m, above 0.
        """
        return self._whole / (1.0 + (mass * self._doubt / noise) ** 2)

    @cached_property
    def _doubt(self) -> np.ndarray:
        """By how much accelerations bend more than elsewhere (N,), SI."""
        _, speed, acceleration = self.path().T
        bends = np.zeros(len(acceleration))
        bends[1:-1] = np.abs(np.diff(acceleration, 2))
        moves = np.abs(speed) > _MOVES * np.sqrt(np.mean(speed**2))
        usual = np.median(bends[moves]) if moves.any() else 0.0
        around = median_filter(bends, _AROUND, mode="nearest")
        usual = np.maximum(usual, around)
        doubt = np.maximum(0.0, bends - _USUAL * usual)
        return maximum_filter1d(doubt, self._beside) * ~self._leaps

    @cached_property
    def _whole(self) -> np.ndarray:
        """Weight of each sample without a mass (N,)."""
        place = np.arange(len(self.time))
        from_end = np.minimum(place, place[::-1]) / max(_ENDS, self.way.reach)
        ends = np.sin(0.5 * np.pi * np.clip(from_end, 0.0, 1.0))
        return ends * ((self.way.jumps == 0.0) | self._leaps)

    @property
    def _beside(self) -> int:
        """Samples over which one spoils accelerations."""
        return 2 * (_BESIDE + math.ceil(_REACHES * self.way.reach)) + 1

    @cached_property
    def _leaps(self) -> np.ndarray:
        """Samples beside a jump (N,), bool: no machine jumps, and what is
        wrong with such a record is to show.
        """
        marks = np.zeros(len(self.time), dtype=bool)
        noise = np.sqrt(2.0) * self.way.sigma
        marks[jumps_in(self.way.displacement, noise)] = True
        return maximum_filter1d(marks, self._beside + 2)


def MakeAxisMotion(
    run: Run, position: str, inputs: tuple[str, ...], sigma: float
) -> AxisMotion:
    """The motion of a run.

    Args:
        run: With all of the columns.
        position: Its column.
        inputs: Columns of extra inputs.
        sigma: Noise of a position reading, m or rad.
    """
    beside = [run.channels[n] for n in inputs]
    return AxisMotion(
        MakePadMotion(run.time_s, run.channels[position], sigma),
        np.ascontiguousarray(np.reshape(beside, (len(inputs), -1)).T)
        if beside
        else np.zeros((len(run.time_s), 0)),
    )

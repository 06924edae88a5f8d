"""What a recorded run imposes on an axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.devices.pad_bench.motion import MakePadMotion, PadMotion
from brace_drake.recording.recording import Run


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

"""What one run looked like, measured and predicted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

VALIDATION = "validation"


@dataclass(frozen=True)
class RunTrace:
    """One run, measured and as the twins predict it.

    Attributes:
        name: Of the run.
        split: "fit" or "validation".
        time_s: (N,).
        channels: Column names, the unit as the last part (C).
        measured: (N, C).
        before: Of the fitted nominal twin (N, C).
        after: With the effects of the verdict (N, C); None without effects.
        floor_rms: Noise floor of each channel (C,), in the channel's unit.
        position: Measured motion that the force answers to (N,), m; or None.
        position_name: What that is, for a reader.
        floor_density: Limits of bands (B + 1,), Hz, and the floor's power of
            a bin, |rfft|^2 / N, in each (B, C); or None.
    """

    name: str
    split: str
    time_s: np.ndarray
    channels: tuple[str, ...]
    measured: np.ndarray
    before: np.ndarray
    after: np.ndarray | None
    floor_rms: np.ndarray
    position: np.ndarray | None = None
    position_name: str = "position"
    floor_density: tuple[np.ndarray, np.ndarray] | None = None

    def normalised_rms(self, predicted: np.ndarray) -> np.ndarray:
        """RMS of measured minus predicted over the floor (C,).

        NaN where the floor is not positive or nothing is finite.
        """
        squares = np.ma.masked_invalid(self.measured - predicted) ** 2
        rms = np.ma.sqrt(squares.mean(axis=0)) / self.floor_rms
        return np.ma.filled(rms, np.nan)

    def main_channel(self) -> int | None:
        """Index of the force along the correction, or of the worst channel."""
        for i, name in enumerate(self.channels):
            if name.endswith("force_y_N") or name == "force_N":
                return i
        return self.worst_channel()

    def worst_channel(self, leave_out: int | None = None) -> int | None:
        """Index of the channel with the largest normalised gap before."""
        gaps = self.normalised_rms(self.before)
        if leave_out is not None:
            gaps[leave_out] = np.nan
        if np.isnan(gaps).all():
            return None
        return int(np.nanargmax(gaps))

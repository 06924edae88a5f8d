"""What one run looked like, measured and predicted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

VALIDATION = "validation"
# A channel whose gap is this part of the worst one's is shown before it where
# it is the force.
_CLEAR = 0.25


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
            a bin in each (B, C), see `NoiseFloor`; or None.
        with_law: With the law of what is left as well (N, C); None without.
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
    with_law: np.ndarray | None = None

    def twins(self) -> list[tuple[str, np.ndarray]]:
        """The predictions that there are, "before", "after" and "law"."""
        each = (
            ("before", self.before),
            ("after", self.after),
            ("law", self.with_law),
        )
        return [(kind, twin) for kind, twin in each if twin is not None]

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

    def ranked_channels(self) -> list[int]:
        """The main channel, then the others with the largest gap first;
        none that was not recorded.
        """
        gaps = self.normalised_rms(self.before)
        order = [int(c) for c in np.argsort(-gaps) if np.isfinite(gaps[c])]
        main = self.main_channel()
        return [c for c in order if c == main] + [c for c in order if c != main]

    def telling_channel(self) -> int | None:
        """The channel that shows the gap to the eye: the main one where its
        gap is a part of the largest one, else that of the largest gap.
        """
        gaps = self.normalised_rms(self.before)
        main, worst = self.main_channel(), self.worst_channel()
        if main is None or worst is None or np.isnan(gaps[main]):
            return worst
        return main if gaps[main] >= _CLEAR * gaps[worst] else worst


def most_telling(traces: Sequence[RunTrace]) -> tuple[int, int] | None:
    """The run and channel in which the gap before the repair is largest, of
    validation runs where there are any; None where nothing was recorded.
    """
    shown = []
    for i, trace in enumerate(traces):
        c = trace.telling_channel()
        if c is not None:
            gap = float(trace.normalised_rms(trace.before)[c])
            shown.append((trace.split == VALIDATION, gap, -i, c))
    if not shown:
        return None
    _, _, place, c = max(shown)
    return -place, c

"""What one run looked like, measured and predicted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import OutputError

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

    def __post_init__(self):
        shape = (len(self.time_s), len(self.channels))
        given = {"measured": self.measured, "before": self.before}
        if self.after is not None:
            given["after"] = self.after
        for part, values in given.items():
            if np.shape(values) != shape:
                raise OutputError(
                    f"run {self.name}: {part} has shape {np.shape(values)},"
                    f" expected {shape}: samples by channels"
                )
        if np.shape(self.floor_rms) != shape[1:]:
            raise OutputError(
                f"run {self.name}: floor_rms has shape"
                f" {np.shape(self.floor_rms)}, expected {shape[1:]}"
            )

    def normalised_rms(self, predicted: np.ndarray) -> np.ndarray:
        """RMS of measured minus predicted over the floor (C,).

        NaN where the floor is not positive or nothing is finite.
        """
        residual = np.asarray(self.measured - predicted, dtype=float)
        finite = np.isfinite(residual)
        count = finite.sum(axis=0)
        power = np.where(finite, residual, 0.0) ** 2
        floor = np.asarray(self.floor_rms, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            rms = np.sqrt(power.sum(axis=0) / count) / floor
        rms[~((floor > 0.0) & np.isfinite(rms))] = np.nan
        return rms

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


def pick_traces(traces: list[RunTrace], most: int) -> list[RunTrace]:
    """Validation runs, or fit runs where there are none; at most `most`."""
    usable = [t for t in traces if len(t.time_s) and t.channels]
    validation = [t for t in usable if t.split == VALIDATION]
    return (validation or usable)[:most]

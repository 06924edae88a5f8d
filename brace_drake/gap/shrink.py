"""How far the gap shrinks on runs that no fit has seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.evaluation import (
    NUM_DITHERS,
    Evaluator,
    PreparedRun,
    is_dithered,
)

_BLOCK_S = 1.0
_RESAMPLES = 1000


@dataclass(frozen=True)
class RunComparison:
    """One run replayed by the nominal and by the repaired twin.

    Attributes:
        prepared: The run.
        before, after: Simulated channels (N, C); `after` None where nothing
            was added.
        dither: Share of the floor's variance that `after` still carries.
    """

    prepared: PreparedRun
    before: np.ndarray
    after: np.ndarray | None
    dither: float = 0.0

    def normalised(self, which: str) -> np.ndarray:
        """Squared residuals in floors (N, used channels)."""
        simulated = getattr(self, which)
        used = self.prepared.used
        residual = (self.prepared.measured - simulated)[:, used]
        squares = (residual / self.prepared.floor.rms[used]) ** 2
        return squares - (self.dither if which == "after" else 0.0)


def compare_runs(
    evaluator: Evaluator, nominal: CandidateFit, winner: CandidateFit | None
) -> list[RunComparison]:
    """Replays every run of an evaluator before and after the repair."""

    def one(prepared):
        before = evaluator.simulate(prepared, nominal.subject, ())
        after, dither = None, 0.0
        if winner is not None:
            uses = winner.uses
            after = evaluator.simulate(prepared, winner.subject, uses)
            dither = (
                1.0 / NUM_DITHERS if is_dithered(evaluator.twin, uses) else 0.0
            )
        return RunComparison(prepared, before, after, dither)

    return evaluator.map(one, [(p,) for p in evaluator.prepared])


def _rms(squares: np.ndarray) -> float:
    return float(np.sqrt(max(0.0, float(np.mean(squares)))))


def closed_share(before: float, after: float) -> float | None:
    """(before - after) / (before - floor), None without a gap before."""
    return (before - after) / (before - 1.0) if before > 1.0 else None


def total_gap(comparisons: list[RunComparison], which: str) -> float:
    """Normalised root mean square over runs, channels and time."""
    squares = np.concatenate([c.normalised(which).ravel() for c in comparisons])
    return _rms(squares)


def channel_gaps(
    comparisons: list[RunComparison], channels: tuple[str, ...], which: str
) -> dict[str, float]:
    """Normalised root mean square of each channel over the runs."""
    gaps = {}
    for c, name in enumerate(channels):
        parts = []
        for comparison in comparisons:
            used = np.flatnonzero(comparison.prepared.used)
            if c in used:
                at = int(np.flatnonzero(used == c)[0])
                parts.append(comparison.normalised(which)[:, at])
        if parts:
            gaps[name] = _rms(np.concatenate(parts))
    return gaps


def closed_interval(
    comparisons: list[RunComparison], rate: float, seed: int
) -> tuple[float, float] | None:
    """95 % interval of the closed share by resampling blocks of time."""
    length = max(1, round(_BLOCK_S * rate))
    blocks = []
    for comparison in comparisons:
        before = comparison.normalised("before").mean(axis=1)
        after = comparison.normalised("after").mean(axis=1)
        for at in range(0, len(before), length):
            part = slice(at, at + length)
            blocks.append((before[part].mean(), after[part].mean()))
    values = np.array(blocks)
    generator = np.random.default_rng([seed, 23])
    shares = []
    for _ in range(_RESAMPLES):
        pick = generator.integers(len(values), size=len(values))
        before, after = np.sqrt(np.maximum(values[pick].mean(axis=0), 0.0))
        share = closed_share(before, after)
        if share is not None:
            shares.append(share)
    if not shares:
        return None
    low, high = np.quantile(shares, [0.025, 0.975])
    return float(low), float(high)

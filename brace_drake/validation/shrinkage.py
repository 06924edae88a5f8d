"""How far the gap shrinks on runs that no fit has seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.identification.evaluation import (
    NUM_DITHERS,
    Evaluator,
    PreparedRun,
    is_dithered,
)
from brace_drake.identification.fits import CandidateFit

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
        return RunComparison(prepared, before, None)

    compared = evaluator.map(one, [(p,) for p in evaluator.prepared])
    if winner is None:
        return compared
    return repair_runs(evaluator, compared, winner)


def repair_runs(
    evaluator: Evaluator, compared: Sequence[RunComparison], fit: CandidateFit
) -> list[RunComparison]:
    """The same runs, with a fit's replays as those after the repair.

    Raises:
        BraceError: Its twin breaks down in one of them.
    """
    is_noisy = is_dithered(evaluator.twin, fit.uses)
    dither = 1.0 / NUM_DITHERS if is_noisy else 0.0

    def one(prepared):
        return evaluator.simulate(prepared, fit.subject, fit.uses)

    replays = evaluator.map(one, [(c.prepared,) for c in compared])
    return [
        replace(c, after=after, dither=dither)
        for c, after in zip(compared, replays, strict=True)
    ]


def is_repaired(comparisons: Sequence[RunComparison]) -> bool:
    """Whether runs were replayed after a repair, and not only before it."""
    return any(c.after is not None for c in comparisons)


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
    found = {
        name: channel_squares(comparisons, c, which)
        for c, name in enumerate(channels)
    }
    return {
        name: _rms(np.concatenate(parts))
        for name, parts in found.items()
        if parts
    }


def channel_squares(
    comparisons: list[RunComparison], channel: int, which: str
) -> list[np.ndarray]:
    """Normalised squares of a channel, of each run that has it (N,)."""
    parts = []
    for comparison in comparisons:
        used = np.flatnonzero(comparison.prepared.used)
        if channel in used:
            at = int(np.flatnonzero(used == channel)[0])
            parts.append(comparison.normalised(which)[:, at])
    return parts


def closed_interval(
    comparisons: list[RunComparison], rate: float, seed: int
) -> tuple[float, float] | None:
    """95 % interval of the closed share by resampling blocks of time."""
    before, after = (
        _blocks([c.normalised(which) for c in comparisons], rate)
        for which in ("before", "after")
    )
    shares = []
    sums = np.column_stack([before[:, 0], after])
    for before, after in np.sqrt(_resampled(sums, seed)):
        share = closed_share(before, after)
        if share is not None:
            shares.append(share)
    if not shares:
        return None
    low, high = np.quantile(shares, [0.025, 0.975])
    return float(low), float(high)


def rms_interval(
    squares: list[np.ndarray], rate: float, seed: int
) -> tuple[float, float]:
    """95 % interval of a root mean square by resampling blocks of time.

    Args:
        squares: Of each run (N,) or (N, channels).
        rate: Hz.
        seed: Of the draws.
    """
    draws = np.sqrt(_resampled(_blocks(squares, rate), seed))
    low, high = np.quantile(draws, [0.025, 0.975])
    return float(low), float(high)


def _blocks(series: list[np.ndarray], rate: float) -> np.ndarray:
    """Sum and number of the values in each block of time of all runs (n, 2).

    The last block of a run is shorter, and runs may have more channels than
    others: a value counts as much wherever it is.
    """
    length = max(1, round(_BLOCK_S * rate))
    parts = [
        values[at : at + length]
        for values in series
        for at in range(0, len(values), length)
    ]
    return np.array([(part.sum(), part.size) for part in parts])


def _resampled(blocks: np.ndarray, seed: int) -> np.ndarray:
    """Means over drawn blocks, no less than 0 (draws, columns).

    Args:
        blocks: Sums, and in the last column numbers of values (n, columns + 1).
        seed: Of the draws.
    """
    generator = np.random.default_rng([seed, 23])
    picks = generator.integers(len(blocks), size=(_RESAMPLES, len(blocks)))
    sums = blocks[picks].sum(axis=1)
    return np.maximum(sums[:, :-1] / sums[:, -1:], 0.0)

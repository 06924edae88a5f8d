"""How far a twin is from its recordings: the gap, in two measures.

In frequency, `Criterion.misfit`: the mean square of residuals that are
whitened, less the noise's 1. All that is decided rests on it, as the noise of
a recording is far from white and a residual of one frequency is not worth one
of another.

In time, `rms_gap`: the root mean square of plain residuals in units of the
noise floor's, 1 for noise alone. It is what a user sees shrink, and what can
be compared between runs, channels and moments. It has no part in a decision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.block_bootstrap import interval_of, pieces_of
from brace_drake.identification.evaluation import (
    NUM_DITHERS,
    Evaluator,
    PreparedRun,
    is_dithered,
)
from brace_drake.identification.fits import CandidateFit

_DRAWS = 1000


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

    def squares(self, which: str) -> np.ndarray:
        """Squared residuals in floors (N, C), NaN where there is none."""
        used = self.prepared.used
        out = np.full(self.prepared.measured.shape, np.nan)
        residual = (self.prepared.measured - getattr(self, which))[:, used]
        out[:, used] = (residual / self.prepared.floor.rms[used]) ** 2
        return out - (self.dither if which == "after" else 0.0)


def compare_runs(
    evaluator: Evaluator, nominal: CandidateFit, winner: CandidateFit | None
) -> list[RunComparison]:
    """Replays every run of an evaluator before and after the repair."""
    runs = evaluator.prepared
    compared = [
        RunComparison(run, before, None)
        for run, before in zip(
            runs, _replay(evaluator, runs, nominal), strict=True
        )
    ]
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
    replays = _replay(evaluator, [c.prepared for c in compared], fit)
    return [
        replace(c, after=after, dither=dither)
        for c, after in zip(compared, replays, strict=True)
    ]


def _replay(evaluator, runs, fit) -> list[np.ndarray]:
    return evaluator.map(
        lambda run: evaluator.simulate(run, fit.subject, fit.uses),
        [(run,) for run in runs],
    )


def is_repaired(compared: Sequence[RunComparison]) -> bool:
    """Whether runs were replayed after a repair, and not only before it."""
    return any(c.after is not None for c in compared)


def rms_gap(
    compared: Sequence[RunComparison], which: str, channel: int | None = None
) -> float | None:
    """Normalised root mean square over runs, time and channels, or of one
    channel; None where no run has it.
    """
    parts = [c.squares(which) for c in compared]
    if channel is not None:
        parts = [p[:, channel] for p in parts]
    squares = np.concatenate([p[~np.isnan(p)] for p in parts])
    if not len(squares):
        return None
    return float(np.sqrt(max(0.0, float(np.mean(squares)))))


def closed_share(before: float, after: float) -> float | None:
    """(before - after) / (before - floor), None without a gap before."""
    return (before - after) / (before - 1.0) if before > 1.0 else None


def closed_interval(
    compared: Sequence[RunComparison], seed: int
) -> tuple[float, float] | None:
    """95 % interval of the closed share of the gap, None without a gap."""
    before, after = (
        sums_of(compared, [c.squares(which) for c in compared])
        for which in ("before", "after")
    )

    def closed(weights):
        count = weights @ before[:, 1]
        sums = weights @ before[:, 0], weights @ after[:, 0]
        return closed_share(*(np.sqrt(max(0.0, s / count)) for s in sums))

    found = interval_of(closed, len(before), [seed, 23], _DRAWS)
    return found and tuple(float(limit) for limit in found)


def rms_interval(
    compared: Sequence[RunComparison], squares: Sequence[np.ndarray], seed: int
) -> tuple[float, float]:
    """95 % interval of a root mean square.

    Args:
        compared: Runs.
        squares: Of each run (N,) or (N, n), NaN where there is nothing.
        seed: Of the draws.
    """
    sums = sums_of(compared, squares)

    def rms(weights):
        total, count = weights @ sums
        return np.sqrt(max(0.0, total / count))

    low, high = interval_of(rms, len(sums), [seed, 23], _DRAWS)
    return float(low), float(high)


def sums_of(
    compared: Sequence[RunComparison], squares: Sequence[np.ndarray]
) -> np.ndarray:
    """Sum and number of the values in each piece of time (n, 2)."""
    return np.array(
        [
            (np.nansum(part), np.count_nonzero(~np.isnan(part)))
            for c, values in zip(compared, squares, strict=True)
            for part in pieces_of(c.prepared.run, values)
        ]
    )

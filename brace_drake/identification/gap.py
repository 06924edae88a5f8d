"""How far a twin is from its recordings: the gap, in two measures.

In frequency, `Criterion.misfit`: the mean square of residuals that are
whitened, less the noise's 1. What is decided on the fit runs rests on it, as
the noise of a recording is far from white and a residual of one frequency is
not worth one of another.

In time, `rms_gap`: the root mean square of plain residuals in units of the
noise floor's, 1 for noise alone. It is what a user sees shrink, and what can
be compared between runs, channels and moments. Of a decision it has the last
word alone: what makes validation runs worse is withdrawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.block_bootstrap import interval_of, pieces_of
from brace_drake.devices.replays import is_dithered
from brace_drake.identification.evaluation import (
    NUM_DITHERS,
    Evaluator,
    PreparedRun,
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
        dither_before: The same of `before`.
    """

    prepared: PreparedRun
    before: np.ndarray
    after: np.ndarray | None
    dither: float = 0.0
    dither_before: float = 0.0

    def squares(self, which: str) -> np.ndarray:
        """Squared residuals in floors (N, C), NaN where there is none."""
        used = self.prepared.used
        out = np.full(self.prepared.measured.shape, np.nan)
        residual = (self.prepared.measured - getattr(self, which))[:, used]
        out[:, used] = (residual / self.prepared.floor.rms[used]) ** 2
        is_after = which == "after"
        return out - (self.dither if is_after else self.dither_before)


def compare_runs(
    evaluator: Evaluator, nominal: CandidateFit, winner: CandidateFit | None
) -> list[RunComparison]:
    """Replays every run of an evaluator before and after the repair."""
    runs = evaluator.prepared
    replays = evaluator.map(
        lambda run: evaluator.simulate(run, nominal.subject, nominal.within),
        [(run,) for run in runs],
    )
    is_noisy = is_dithered(evaluator.twin, nominal.within)
    dither = 1.0 / NUM_DITHERS if is_noisy else 0.0
    compared = [
        RunComparison(run, before, None, dither_before=dither)
        for run, before in zip(runs, replays, strict=True)
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
    uses = (*fit.uses, *fit.within)
    is_noisy = is_dithered(evaluator.twin, uses)
    dither = 1.0 / NUM_DITHERS if is_noisy else 0.0
    replays = evaluator.map(
        lambda run: evaluator.simulate(run, fit.subject, uses),
        [(c.prepared,) for c in compared],
    )
    return [
        replace(c, after=after, dither=dither)
        for c, after in zip(compared, replays, strict=True)
    ]


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


def interval_of_rms(
    compared: Sequence[RunComparison],
    squares: Sequence[Sequence[np.ndarray]],
    seed: int,
    figure: Callable[..., float | None] = lambda rms: rms,
) -> tuple[float, float] | None:
    """95 % interval of a figure of root mean squares.

    Args:
        compared: Runs.
        squares: For each root mean square, of each run (N,) or (N, n); NaN
            where there is nothing.
        seed: Of the draws.
        figure: From the root mean squares; None where there is none.
    """
    # Sum and number of the values in each piece of time.
    sums = np.array(
        [
            [
                (np.nansum(part), np.count_nonzero(~np.isnan(part)))
                for c, values in zip(compared, of_runs, strict=True)
                for part in pieces_of(c.prepared.run, values)
            ]
            for of_runs in squares
        ]
    )

    def drawn(weights):
        means = [total / count for total, count in weights @ sums]
        return figure(*(np.sqrt(max(0.0, mean)) for mean in means))

    found = interval_of(drawn, sums.shape[1], [seed, 23], _DRAWS)
    return found and (float(found[0]), float(found[1]))

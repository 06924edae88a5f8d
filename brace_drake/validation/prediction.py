"""How well the causes predict runs that no fit has seen.

A cause of many parameters leaves less on the runs that it was fitted to, but
not on others; so what a cause leaves there is its score, whatever its freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import (
    RunComparison,
    interval_of_rms,
    is_repaired,
    repair_runs,
    rms_gap,
)

# A replay of each costs little, of all the pairs that were tried much.
_MOST = 8


@dataclass(frozen=True)
class Prediction:
    """What a cause leaves on runs that it has not seen.

    Attributes:
        fit: Of the cause.
        gap: Normalised root mean square, 1 for noise alone.
        interval: 95 % of it, by resampling blocks of time.
    """

    fit: CandidateFit
    gap: float
    interval: tuple[float, float]


def predict_runs(
    validation: Evaluator,
    compared: Sequence[RunComparison],
    winner: CandidateFit | None,
    fits: Sequence[CandidateFit],
    seed: int,
) -> list[Prediction]:
    """Predictions by the winner and by causes that leave least on the fit runs,
    those that were led to their end first.

    Args:
        validation: Over runs that no fit has seen.
        compared: Those runs, replayed before and after the winner's repair.
        winner: None where there is none.
        fits: Of causes. Who was not searched predicts nothing, nor who has
            parameters of single runs, which would have to be fitted to these
            runs, nor whose twin breaks down.
        seed: Of the intervals.
    """
    if not compared:
        return []
    able = [
        f
        for f in sorted(fits, key=lambda f: (not f.refined, f.excess))
        if f.is_searched and not f.has_run_parameters
    ]
    rivals = [f for f in able[:_MOST] if f is not winner]
    found = []
    for fit in [winner, *rivals] if is_repaired(compared) else rivals:
        replayed = compared
        if fit is not winner:
            try:
                replayed = repair_runs(validation, compared, fit)
            except BraceError:
                continue
        gap = rms_gap(replayed, "after")
        if np.isfinite(gap):
            squares = [c.squares("after") for c in replayed]
            interval = interval_of_rms(replayed, [squares], seed)
            found.append(Prediction(fit, gap, interval))
    return found

"""How well the causes predict runs that no fit has seen.

A cause of many parameters leaves less on the runs that it was fitted to, but
not on others; so what a cause leaves there is its score, whatever its freedom.
"""

from __future__ import annotations

from dataclasses import dataclass

from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.run_parameters import has_run_parameters
from brace_drake.gap.shrink import compare_runs, rms_interval, total_gap

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
    nominal: CandidateFit,
    fits: list[CandidateFit],
    rate: float,
    seed: int,
) -> list[Prediction]:
    """Predictions by the causes that leave least on the fit runs.

    Args:
        validation: Over runs that no fit has seen.
        nominal: The nominal fit.
        fits: Of causes. Those with parameters of single runs predict nothing:
            they would have to be fitted to these runs.
        rate: Hz.
        seed: Of the intervals.
    """
    if not validation.prepared:
        return []
    able = [
        f
        for f in sorted(fits, key=lambda f: f.excess)
        if f.solution.jacobian is not None and not has_run_parameters(f)
    ]
    found = []
    for fit in able[:_MOST]:
        replayed = compare_runs(validation, nominal, fit)
        squares = [c.normalised("after").mean(axis=1) for c in replayed]
        interval = rms_interval(squares, rate, seed)
        found.append(Prediction(fit, total_gap(replayed, "after"), interval))
    return found

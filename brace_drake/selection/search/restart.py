"""Searches that begin again near where one has ended."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.identification.evaluation import Evaluator, sticks
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.acceptance import smallest_share
from brace_drake.selection.decision import explains
from brace_drake.selection.measures import closed_amplitude, is_flexible
from brace_drake.selection.null_bootstrap import NullDistribution
from brace_drake.selection.search.shortlist import try_refine

# So far, in parts of each parameter: the subject's are known by a part, those
# of the effects nearly.
_SUBJECT, _EFFECTS = 0.2, 0.02
_RESTARTS = 3
# One that leaves less than this share has come out of where it was caught.
_ESCAPED = 0.5


def is_caught(
    evaluator: Evaluator,
    nominal: CandidateFit,
    pair: CandidateFit,
    null: NullDistribution,
) -> bool:
    """Whether a pair of few parameters takes most of the gap, and yet leaves
    more than two effects may.

    What drives leave that stick is no kink, and their search is dear.
    """
    if is_flexible(pair) or len(pair.effects) < 2 or not pair.is_searched:
        return False
    if sticks(evaluator.twin, pair.uses):
        return False
    closed = closed_amplitude(evaluator, nominal, pair)
    enough = closed >= smallest_share(evaluator)
    return enough and not explains(evaluator, nominal, pair, null)


def restart(
    evaluator: Evaluator, fit: CandidateFit, seed: int
) -> list[CandidateFit]:
    """The search again from places near its end, up to three of them.

    A limit, a gap or a stop has a kink where it is reached, and a search over
    two effects and the subject may be caught beside it.

    Args:
        evaluator: Over the fit runs.
        fit: Where a search stands, of few parameters.
        seed: Of the places.

    Returns:
        The first fit that leaves less than half as much, if any does.
    """
    rng = np.random.default_rng([seed, 11])
    for _ in range(_RESTARTS):
        again = try_refine(evaluator, _moved(fit, rng))
        if again.refined and again.excess < _ESCAPED * fit.excess:
            return [again]
    return []


def _moved(fit: CandidateFit, rng: np.random.Generator) -> CandidateFit:
    subject = fit.subject * _factors(rng, len(fit.subject), _SUBJECT)
    values = []
    for effect, mine in fit.uses:
        moved = mine.copy()
        moved[effect.is_continuous] *= _factors(
            rng, int(effect.is_continuous.sum()), _EFFECTS
        )
        values.append(moved)
    return replace(fit, subject=subject, values=tuple(values), refined=False)


def _factors(rng: np.random.Generator, count: int, size: float) -> np.ndarray:
    return np.exp(size * rng.standard_normal(count))

"""A number that a fit has beyond its tolerance, as the effect that it is.

Such a fit explains what it does by a number that no machine of its scenario
has. With an effect in the number's place, as strong as the number is off, it
leaves the same and stretches nothing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.candidate import with_one_more
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.within import refit_within, set_out
from brace_drake.selection.tolerated import left_by


def fit_beyond(
    evaluator: Evaluator, base: CandidateFit, criterion: Criterion
) -> list[CandidateFit]:
    """A fit with each such number as an effect, refined, where it then leaves
    much less: what else stretches numbers stays.

    Args:
        evaluator: Over the fit runs; it takes the fit's tolerances.
        base: The fit.
        criterion: Of the campaign.
    """
    if base.stretch <= thresholds.WITHIN:
        return []
    set_out(evaluator, base)
    lines, found = Linearisation(evaluator, base), []
    most = thresholds.WORTH_A_SET * left_by(base, evaluator.count)
    for effect, values in _beyond(lines):
        candidate = with_one_more(lines, effect, values)
        if candidate is None or not candidate.step(lines, thresholds.STEPS):
            continue
        if candidate.excess < most:
            fit = candidate.fit()
            found.append(refit_within(evaluator, fit, criterion.nuisances))
    return found


def _beyond(lines: Linearisation) -> Iterator[tuple[Effect, np.ndarray]]:
    """Effects for numbers beyond their tolerances, as strong as they are off;
    of numbers by the dozen none, nor of friction, which sticks.
    """
    evaluator, taken = lines.evaluator, {e.name for e in lines.base.effects}
    for nuisance, t in estimate_off(evaluator, lines.base):
        ((card, values),) = nuisance.uses
        if abs(t) <= thresholds.WITHIN or card.name in taken:
            continue
        for effect in evaluator.effects:
            is_it = effect.name == card.name and not effect.variant
            if is_it and not (effect.is_flexible or effect.dithered):
                yield effect, np.clip(t * values, effect.lower, effect.upper)

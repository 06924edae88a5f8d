"""The end of a search: the best explanation beside tolerances as they act
there, and the level that its friction adds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.tolerances import UsesOff, sizes_off
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_effects
from brace_drake.identification.held_out import check_fit, estimate_off
from brace_drake.identification.numbers.numbers_along import correct_along
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.level import with_level
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.selection.same_model import comes_down_to
from brace_drake.selection.search.nested import special_cases
from brace_drake.selection.search.within import refit_within, set_out

# Fits that are led to their end at most, with their special cases.
_ROUNDS = 4


def settle(
    evaluator: Evaluator,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
) -> tuple[Criterion, list[CandidateFit]]:
    """The criterion and the fits that a verdict is decided on.

    The best of them is led to its end and compared with its special case, as
    long as another is the best then, beside the level that its friction adds.

    Args:
        evaluator: Over the fit runs.
        criterion: Of the search.
        fits: Of the search.
    """
    criterion, fits = replace(criterion, is_last=True), list(fits)
    ended: list[CandidateFit] = []
    for _ in range(_ROUNDS):
        criterion, best = _with_best(evaluator, criterion, fits)
        if not best.effects or any(best is f for f in ended):
            return criterion, fits
        set_out(evaluator, best)
        again = best
        if not best.is_settled:
            again = refit_within(evaluator, best, criterion.nuisances)
        again = check_fit(evaluator, correct_along(evaluator, again))
        fits = [again if f is best else f for f in fits]
        ended.append(again)
        simpler = _simplify(evaluator, criterion, again)
        if simpler is not None:
            ended.append(simpler)
            fits = [f for f in fits if not comes_down_to(f.uses, simpler.uses)]
            fits.append(simpler)
    criterion, _ = _with_best(evaluator, criterion, fits)
    return criterion, fits


def _with_best(
    evaluator: Evaluator, criterion: Criterion, fits: Sequence[CandidateFit]
) -> tuple[Criterion, CandidateFit]:
    """The criterion beside the level of the best fit, and the best there."""
    every = [criterion.nominal, *fits]
    criterion = criterion.over(every)
    best = best_of_kinds(criterion, every)[0]
    criterion = with_level(evaluator, criterion, best)
    return criterion, best_of_kinds(criterion, every)[0]


def _simplify(
    evaluator: Evaluator, criterion: Criterion, best: CandidateFit
) -> CandidateFit | None:
    """The best with the special case of a richer effect, led on as it was: what
    is compared with it has to stand at its own best. None without one.
    """
    found = []
    for start in special_cases(best, evaluator.effects):
        set_out(evaluator, best)
        try:
            fit = fit_effects(evaluator, start.effects, start)
        except (BraceError, ValueError):
            # Its twin breaks down.
            continue
        fit = refit_within(evaluator, fit, criterion.nuisances)
        found.append(check_fit(evaluator, correct_along(evaluator, fit)))
    return min(found, key=criterion.score, default=None)


def set_within(
    evaluator: Evaluator,
    fit: CandidateFit,
    uses_off: UsesOff,
    most: float = math.inf,
) -> CandidateFit:
    """A fit with its numbers as far off as it has them.

    Args:
        evaluator: Over the fit runs.
        fit: One that was searched.
        uses_off: From numbers that are off, SI units, to effects.
        most: Tolerances that a number is off at most: what is stretched
            farther would hide a gap behind numbers that no machine has.
    """
    has_room = len(fit.effects) < evaluator.room
    numbers = estimate_off(evaluator, fit)
    if not (numbers and fit.is_searched and has_room):
        return fit
    nuisances, off = zip(*numbers, strict=True)
    off = np.clip(off, -most, most)
    return replace(fit, within=uses_off(sizes_off(nuisances, off)))

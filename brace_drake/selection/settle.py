"""The end of a search: the best explanation beside tolerances as they act
there, and the level that its friction adds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from brace_drake.core.errors import BraceError
from brace_drake.devices.tolerances import UsesOff, sizes_off
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import (
    CandidateFit,
    correct_fit,
    fit_effects,
)
from brace_drake.identification.held_out import check_fit, estimate_off
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.level import with_level
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.selection.same_model import comes_down_to
from brace_drake.selection.search.nested import special_case
from brace_drake.selection.search.within import refit_within, set_out


def settle(
    evaluator: Evaluator,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
) -> tuple[Criterion, list[CandidateFit]]:
    """The criterion and the fits that a verdict is decided on.

    Args:
        evaluator: Over the fit runs.
        criterion: Of the search.
        fits: Of the search.
    """
    criterion = replace(criterion, is_last=True)
    best = best_of_kinds(criterion, [criterion.nominal, *fits])[0]
    if not best.effects:
        return with_level(evaluator, criterion, best), list(fits)
    set_out(evaluator, best)
    again = best
    if not best.is_settled:
        again = refit_within(evaluator, best, criterion.nuisances)
    again = check_fit(evaluator, correct_fit(evaluator, again))
    fits = [again if f is best else f for f in fits]
    simpler = _simplify(evaluator, criterion, again)
    if simpler is not None:
        fits.append(simpler)
        fits = [f for f in fits if not comes_down_to(f.uses, simpler.uses)]
        again = best_of_kinds(criterion, [criterion.nominal, *fits])[0]
    return with_level(evaluator, criterion, again), fits


def _simplify(
    evaluator: Evaluator, criterion: Criterion, best: CandidateFit
) -> CandidateFit | None:
    """The best with the special case of a richer effect, led on as it was: what
    is compared with it has to stand at its own best. None without one.
    """
    start = special_case(best, evaluator.effects)
    if start is None:
        return None
    set_out(evaluator, best)
    try:
        fit = fit_effects(evaluator, start.effects, start)
    except (BraceError, ValueError):
        # Its twin breaks down.
        return None
    fit = refit_within(evaluator, fit, criterion.nuisances)
    return check_fit(evaluator, correct_fit(evaluator, fit))


def set_within(
    evaluator: Evaluator,
    fit: CandidateFit,
    uses_off: UsesOff,
) -> CandidateFit:
    """A fit with its numbers as far off as it has them, within tolerances.

    Args:
        evaluator: Over the fit runs.
        fit: One that was searched.
        uses_off: From numbers that are off, SI units, to effects.
    """
    has_room = len(fit.effects) < evaluator.room
    numbers = estimate_off(evaluator, fit)
    if not (numbers and fit.is_searched and has_room):
        return fit
    nuisances, off = zip(*numbers, strict=True)
    return replace(fit, within=uses_off(sizes_off(nuisances, off)))

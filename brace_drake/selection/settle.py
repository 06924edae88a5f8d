"""The end of a search: the best explanation beside tolerances as they act
there, and the level that its friction adds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import linearise_tolerances
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.selection.criterion import Criterion, best_of_kinds
from brace_drake.selection.level import with_level
from brace_drake.selection.search.shortlist import try_refine


def settle(
    evaluator: Evaluator,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
) -> tuple[Criterion, list[CandidateFit]]:
    """The criterion and the fits that a verdict is decided on.

    Args:
        evaluator: Over the fit runs; it keeps the last linearisation.
        criterion: Of the search.
        fits: Of the search.
    """
    nuisances = criterion.nuisances
    best = best_of_kinds(criterion, [criterion.nominal, *fits])[0]
    if nuisances and best.effects:
        again = _refit_within(evaluator, best, nuisances)
        fits = [again if f is best else f for f in fits]
        best = again
    return with_level(evaluator, criterion, best), list(fits)


def _refit_within(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """A fit led on with tolerances linearised where it stands.

    Effects on which noise acts as a dither are left out of that: they change
    little of what a tolerance does, and much of what it costs.
    """
    smooth = tuple(u for u in fit.uses if not u[0].dithered)
    before = evaluator.tolerances
    found = linearise_tolerances(evaluator, nuisances, fit.subject, smooth)
    if found is None:
        return fit
    evaluator.tolerances = found
    again = try_refine(evaluator, fit)
    if again is fit or again.excess > fit.excess:
        evaluator.tolerances = before
        return fit
    return again


def set_within(
    evaluator: Evaluator,
    fit: CandidateFit,
    uses_off: Callable[[Mapping[str, float]], tuple[Use, ...]],
) -> CandidateFit:
    """A fit with its numbers as far off as it has them, within tolerances.

    Args:
        evaluator: Over the fit runs.
        fit: One that was searched.
        uses_off: From numbers that are off, SI units, to effects.
    """
    number = len(evaluator.twin.carried)
    has_room = number + len(fit.effects) < MAX_EFFECTS
    numbers = estimate_off(evaluator, fit)
    if not (numbers and fit.is_searched and has_room):
        return fit
    off: dict[str, float] = {}
    for nuisance, t in numbers:
        size = t * nuisance.deviation
        off[nuisance.name] = off.get(nuisance.name, 0.0) + size
    return replace(fit, within=uses_off(off))

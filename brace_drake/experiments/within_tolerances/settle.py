"""The end of a search: the best explanation beside tolerances as they act
there, and the level that its friction adds.
"""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import linearise_tolerances
from brace_drake.experiments.within_tolerances.criterion import (
    Criterion,
    best_of_kinds,
)
from brace_drake.experiments.within_tolerances.fitted import try_refine
from brace_drake.experiments.within_tolerances.level import with_level
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit


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

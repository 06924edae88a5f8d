"""Fits beside numbers known to a tolerance, as these act there.

What a number that is off does depends on what else is there: where drives stick
a little, the ring answers to an anchor otherwise than where they do not. So
tolerances are linearised again where a fit stands, with its effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import linearise_tolerances
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.selection.search.shortlist import try_refine


def set_out(evaluator: Evaluator, fit: CandidateFit) -> None:
    """Takes tolerances as they are linearised at a fit."""
    known = fit.tolerances
    evaluator.tolerances = known and (known.whole or known)


def refit_within(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """A fit led to its end with tolerances linearised where it stands; as it
    is, or with those before, where that leaves no less.

    Args:
        evaluator: Over the fit runs; it keeps the linearisation, if the fit
            does.
        fit: That was searched.
        nuisances: Numbers known to a tolerance.
    """
    number = len(fit.effects) + len(evaluator.twin.carried)
    before, found = evaluator.tolerances, None
    if nuisances and number < MAX_EFFECTS:
        found = linearise_tolerances(
            evaluator, nuisances, fit.subject, fit.uses
        )
    if found is not None:
        evaluator.tolerances = found
        again = try_refine(evaluator, fit)
        if again is not fit and again.excess <= fit.excess:
            return replace(again, is_settled=True)
        evaluator.tolerances = before
    fit = fit if fit.refined else try_refine(evaluator, fit)
    return replace(fit, is_settled=True)

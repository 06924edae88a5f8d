"""Fits beside numbers known to a tolerance, as these act there.

What a number that is off does depends on what else is there: where drives stick
a little, the ring answers to an anchor otherwise than where they do not, and to
a small error otherwise than to a large one. So tolerances are linearised again
where a fit stands, with its effects, and where it has the numbers themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import linearise_tolerances
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.selection import thresholds
from brace_drake.selection.search.shortlist import try_refine

# Linearisations of numbers that bend.
_ROUNDS = 3


def set_out(evaluator: Evaluator, fit: CandidateFit) -> None:
    """Takes tolerances as they are linearised at a fit."""
    known = fit.tolerances
    evaluator.tolerances = known and (known.whole or known)


def refit_within(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """A fit led to its end with tolerances linearised where it stands; as it
    is, or with those before, where that leaves no less.

    Where noise dithers its drives, numbers bend: then they are linearised
    anew where the fit has them, as long as that takes something.

    Args:
        evaluator: Over the fit runs; it keeps the linearisation, if the fit
            does.
        fit: That was searched.
        nuisances: Numbers known to a tolerance.
    """
    able = bool(nuisances) and len(fit.effects) < evaluator.room
    before, best, last = evaluator.tolerances, fit, fit
    is_off = fit.tolerances is not None and fit.tolerances.off is not None
    rounds = range(int(is_off), _ROUNDS if fit.is_dithered else 1)
    for place in rounds if able else ():
        again = _refit_once(evaluator, last, nuisances, place > 0)
        if again is None:
            break
        is_better = again.refined and (
            again.excess <= best.excess or not best.refined
        )
        small = again.excess > thresholds.WORTH_A_ROUND * last.excess
        best, last = again if is_better else best, again
        if place > 0 and small:
            break
    evaluator.tolerances = before
    if best is not fit:
        set_out(evaluator, best)
    elif not fit.refined:
        best = try_refine(evaluator, fit)
    return replace(best, is_settled=True)


def _refit_once(
    evaluator: Evaluator,
    fit: CandidateFit,
    nuisances: Sequence[Nuisance],
    is_off: bool,
) -> CandidateFit | None:
    """With tolerances linearised at a fit, which the evaluator then has; None
    where the twin breaks down there.

    Args:
        evaluator, fit, nuisances: See `refit_within`.
        is_off: Whether numbers are taken where the fit has them; what a fit
            with other effects tells of them would lead astray.
    """
    uses_off, off = fit.tolerances and fit.tolerances.uses_off, None
    if is_off and uses_off:
        known = {id(n): t for n, t in estimate_off(evaluator, fit)}
        off = np.array([max(known.get(id(n), 0.0), n.lower) for n in nuisances])
    found = linearise_tolerances(
        evaluator, nuisances, fit.subject, fit.uses, uses_off, off
    )
    if found is None:
        return None
    evaluator.tolerances = found
    return try_refine(evaluator, fit)

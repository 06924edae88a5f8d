"""Explanations weighed on runs that no fit has seen.

What a motion left out would be like is predicted along a straight line; a new
run is replayed. Each is half of what the criterion takes for an explanation's
misfit on motions that it has not seen, so that what either speaks against is
not announced, whatever it leaves on its own runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.criterion import Criterion
from brace_drake.validation.run_parameters import adapt_to_runs


def weigh_on_new_runs(
    validation: Evaluator, criterion: Criterion, fits: Sequence[CandidateFit]
) -> tuple[Criterion, list[CandidateFit]]:
    """The criterion and fits, with what new runs say of those that may win.

    A fit whose twin breaks down there stays as it is.

    Args:
        validation: Over those runs.
        criterion, fits: Of the fit runs, numbers as far off as fits have them.
    """
    if not validation.prepared:
        return criterion, list(fits)
    able = [f for f in [criterion.nominal, *fits] if f.may_win]
    there = [adapt_to_runs(validation, f) for f in able]
    points = [(f.subject, (*f.uses, *f.within)) for f in there]
    found = validation.weighted_residuals(points)
    weighed = {}
    for fit, (_, uses), rows in zip(able, points, found, strict=True):
        if rows is not None:
            misfit = validation.excess(rows, uses) / validation.count
            left_out = misfit if fit.held_out is None else fit.held_out
            unseen = 0.5 * (left_out + misfit)
            weighed[id(fit)] = replace(fit, held_out=unseen)
    nominal = weighed.get(id(criterion.nominal), criterion.nominal)
    return (
        replace(criterion, nominal=nominal),
        [weighed.get(id(f), f) for f in fits],
    )

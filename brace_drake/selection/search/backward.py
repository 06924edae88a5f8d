"""The way back: the best set of effects without each of them."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.core.errors import BraceError
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.selection.search.candidate import candidate_of
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.shortlist import try_refine
from brace_drake.selection.search.within import set_out


def without_each(
    evaluator: Evaluator,
    criterion: Criterion,
    known: Sequence[CandidateFit],
    number: int,
) -> list[CandidateFit]:
    """The best set without each of its effects, led on from where it stands:
    that may be another end than the way from the smaller set came to.

    Args:
        evaluator: Over the fit runs.
        criterion: Of the campaign.
        known: Fits of the search so far.
        number: Of effects of the set.
    """
    ranked = best_of_kinds(criterion, known)
    best = next(
        (f for f in ranked if len(criterion.findings(f)) == number), None
    )
    if best is None:
        return []
    found = []
    set_out(evaluator, best)
    try:
        lines = Linearisation(evaluator, criterion.nominal)
    except BraceError:
        return []
    for out in criterion.findings(best):
        kept = [u for u in best.uses if u[0] is not out]
        if not kept:
            continue
        less = candidate_of(lines, kept, best.subject, best.spread)
        if less is not None and less.step(lines, thresholds.STEPS, own=True):
            found.append(try_refine(evaluator, less.fit()))
    return found

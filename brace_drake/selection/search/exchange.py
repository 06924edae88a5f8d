"""Exchange: the best set with one effect replaced by one that acts like it.

A search that comes by one of two confusable effects ends there, as nothing is
left: the other is never seen at its own best. So each effect of the best set is
replaced by those that it is confused with by the cards, from where the set
stands (sequential replacement; Miller, Subset Selection in Regression, chapter
3).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, refined
from brace_drake.selection.search.candidate import (
    Candidate,
    best_of_starts,
    candidate_of,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.within import refit_within, set_out
from brace_drake.selection.tolerated import left_by


def exchanged(
    evaluator: Evaluator,
    criterion: Criterion,
    best: CandidateFit,
    known: Sequence[CandidateFit],
) -> list[CandidateFit]:
    """The best set with each of its effects replaced by others, where that
    leaves about as little; led to its end.

    Args:
        evaluator: Over the fit runs.
        criterion: Of the campaign.
        best: The set; its effects within tolerances stay.
        known: Fits of the search so far; none is made again.
    """
    found: list[CandidateFit] = []
    named = criterion.findings(best)
    set_out(evaluator, best)
    if not named:
        return found
    try:
        lines = Linearisation(evaluator, best)
    except BraceError:
        return found
    trust = thresholds.TRUST * evaluator.count
    left = max(0.0, left_by(best, evaluator.count))
    most = thresholds.NEAR * (left + trust)
    done = {f.kinds for f in refined(known)}
    for out in named:
        kept = [use for use in best.uses if use[0] is not out]
        causes = frozenset(e.cause for e, _ in kept)
        for forms in _confusable(evaluator.effects, out, kept):
            if causes | {forms[0].cause} in done:
                continue
            # A number that is replaced would take its own place again.
            evaluator.tolerances = best.tolerances
            candidate = best_of_starts(lines, _begun(lines, kept, forms, most))
            if candidate is not None and candidate.excess <= most:
                fit = candidate.fit()
                set_out(evaluator, fit)
                fit = refit_within(evaluator, fit, criterion.nuisances)
                found.append(fit)
    set_out(evaluator, best)
    return found


def _confusable(
    effects: Sequence[Effect], out: Effect, kept: Sequence[Use]
) -> Iterator[list[Effect]]:
    """Forms of each effect that another is confused with, either way round;
    none of dozens of parameters.
    """
    forms: dict[str, list[Effect]] = {}
    for effect in effects:
        is_like = effect.name in out.impostors or out.name in effect.impostors
        if not is_like or effect.is_flexible or effect.is_alike(out):
            continue
        if not any(effect.is_alike(other) for other, _ in kept):
            forms.setdefault(effect.cause, []).append(effect)
    yield from forms.values()


def _begun(
    lines: Linearisation,
    kept: Sequence[Use],
    forms: Sequence[Effect],
    most: float,
) -> list[Candidate]:
    """What is kept with each form from each start: those of the few that begin
    best that a step brings near enough, or much nearer.
    """
    best = lines.base
    found = [
        candidate_of(lines, [*kept, (form, start)], best.subject, best.spread)
        for form in forms
        for start in form.starts()
    ]
    able = sorted((c for c in found if c is not None), key=lambda c: c.excess)
    near = []
    for candidate in able[: thresholds.EXCHANGED_STARTS]:
        worth = max(most, thresholds.WORTH_A_SET * candidate.excess)
        if candidate.step(lines, 1, own=True) and candidate.excess <= worth:
            near.append(candidate)
    return near

"""A second effect that takes little, beside one that explains the gap, and two
of few parameters in the place of one of dozens.

What one leaves may be well within what the level of the noise may be off, and
still more than chance or the twin's own errors give to another effect: that
another one takes it tells, not how much there is.
"""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator, is_dithered
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, plausible
from brace_drake.selection.search.candidate import Candidate
from brace_drake.selection.search.joint_refit import refine_best
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import (
    Say,
    others,
    predict,
    screen,
    search_best,
)
from brace_drake.selection.search.shortlist import (
    best_fits,
    best_of_each,
    try_refine,
)


def try_small(
    criterion: Criterion,
    evaluator: Evaluator,
    singles: Sequence[CandidateFit],
    effects: Sequence[Effect],
    known: Sequence[CandidateFit],
    seed: int,
    say: Say,
) -> list[CandidateFit]:
    """Pairs of the single effect that explains, be it to the floor, with a
    second one that takes little; where it is one of dozens of parameters that
    shows in the leg lengths at rest, pairs of few that do.

    Args:
        criterion: With its null distribution.
        evaluator: Over the fit runs.
        singles: Fits of single effects.
        effects: Second ones.
        known: Pairs that were found before.
        seed: Of places where searches begin again.
        say: Progress, shares of this search.
    """
    best = next(iter(plausible(singles)), criterion.nominal)
    if not criterion.explains(best):
        return []
    if best.is_flexible and best.effects[0].at_rest:
        found = list(known)
        few = [f for f in singles if f.effects[0].at_rest]
        few = [f for f in few if not f.is_flexible]
        for fit in sorted(few, key=lambda f: f.excess)[:1]:
            seconds = others(effects, fit, flexible=False)
            pairs = try_fewer(evaluator, fit, best, seconds, say)
            excess = fit.excess
            found += refine_best(criterion, evaluator, pairs, excess, seed)
        return best_of_each(found)
    try:
        base = Linearisation(evaluator, best)
    except BraceError:
        return []
    seconds = others(effects, best, flexible=False)
    return try_small_second(base, seconds, criterion, say)


def try_small_second(
    base: Linearisation,
    effects: Sequence[Effect],
    criterion: Criterion,
    say: Say,
) -> list[CandidateFit]:
    """The base with the second effect that takes most, refined.

    None where the base or that effect is averaged over noise, and its replays
    are no nearer than what is looked for.

    Args:
        base: At the single effect that explains.
        effects: Second ones.
        criterion: With its null distribution.
        say: Progress, shares of this search.

    Returns:
        Fits of those searched, up to that one refined; none where no effect
        takes more than noise would.
    """
    evaluator, fit = base.evaluator, base.base
    if fit.is_dithered:
        return []
    candidates: list[Candidate] = []
    # A straight way predicts half of what a search takes, or less.
    least = criterion.null.least_gain(1) * evaluator.count / thresholds.BENDS
    for i, effect in enumerate(effects):
        if is_dithered(evaluator.twin, [(effect, ())]):
            continue
        say(f"cause {fit.name}+{effect.key}", 0.6 * i / len(effects))
        candidates += predict(base, effect, least)
    bar = base.excess - least
    best: dict[str, Candidate] = {}
    for candidate in sorted(candidates, key=lambda c: c.predicted):
        if candidate.predicted < bar:
            best.setdefault(candidate.added.key, candidate)
    searched = list(best.values())[: thresholds.SMALL_PLACES]
    for i, candidate in enumerate(searched):
        say(f"cause {candidate.fit().name}", 0.6 + 0.1 * i)
        candidate.step(base, thresholds.STEPS)
    fits = [f for f in best_fits(searched) if f.is_searched]
    for place, found in enumerate(fits):
        if found.excess > bar:
            break
        # One of many parameters may take most and yet no more than it would.
        fits[place] = try_refine(evaluator, found)
        if fits[place].refined and criterion.gains(fits[place], fit):
            return fits
    return []


def try_fewer(
    evaluator: Evaluator,
    fit: CandidateFit,
    many: CandidateFit,
    effects: Sequence[Effect],
    say: Say,
) -> list[Candidate]:
    """An effect of few parameters with second ones, where one of dozens that
    shows where it does explains the gap, but may only cover it.

    Args:
        evaluator: Over the fit runs.
        fit: Of the effect of few parameters.
        many: That of dozens.
        effects: Second ones.
        say: Progress, shares of this search.
    """
    if not fit.is_searched:
        return []
    try:
        base = Linearisation(evaluator, fit)
    except BraceError:
        return []
    most = max(many.excess, thresholds.TWIN_ERROR * evaluator.count)
    candidates = screen(base, effects, say)
    search_best(base, candidates, say, enough=most, must_explain=True)
    return candidates

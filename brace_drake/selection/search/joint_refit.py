"""Fits that set out again: beside parameters that are no sample of their
prior, and near where a search was caught.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_effects
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, refined
from brace_drake.selection.search.candidate import Candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import (
    Say,
    predict,
    screen,
    search_best,
)
from brace_drake.selection.search.shortlist import (
    best_fits,
    refine,
    try_refine,
)


def implausible(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Single effects of parameters drawn alike that leave too much or are no
    sample of their prior, best first.
    """
    found = [
        f
        for f in fits
        if len(f.effects) == 1
        and f.spread is not None
        and f.is_searched
        and not (f.refined and f.is_scattered)
    ]
    return sorted(found, key=lambda f: f.excess)


def refit_with_second(
    evaluator: Evaluator,
    fit: CandidateFit,
    effects: Sequence[Effect],
    say: Say,
) -> list[CandidateFit]:
    """The fit with the second effect that is predicted to leave least.

    The right one makes the fit's parameters a sample of their prior again:
    what they cost counts too. From where they have gone no way leads back, so
    that both set out afresh.

    Args:
        evaluator: Over the fit runs.
        fit: One of `implausible`.
        effects: Second ones.
        say: Progress, shares of this search.

    Returns:
        The pair, before it others of second effects that were predicted about
        as well and leave less; none where no prediction is good enough.
    """
    try:
        beside = Linearisation(evaluator, fit, with_prior=True)
    except BraceError:
        return []
    candidates = []
    for effect in effects:
        say(f"cause {fit.name}+{effect.key}", 0.3)
        candidates += predict(beside, effect)
    best = min(candidates, key=lambda c: c.predicted, default=None)
    usual = fit.num_prior
    most = thresholds.JOINT_PREDICTED * (beside.remaining - usual)
    if best is None or best.predicted - usual > most:
        return []
    (first, _), (second, values) = best.problem.split(best.z)[1]
    say(f"cause {fit.name}+{second.key}", 0.6)
    try:
        pair = fit_effects(evaluator, (first, second), (first.off(), values))
    except (BraceError, ValueError):
        return []
    near = thresholds.JOINT_RIVAL * max(0.0, best.predicted - usual)
    rivals = {
        c.added.key: c.added
        for c in candidates
        if c.predicted <= usual + near and c.added is not second
    }

    def say_rest(what, share):
        say(what, 0.6 + 0.4 * share)

    rest = replace_second(evaluator, pair, list(rivals.values()), say_rest)
    return [*rest, pair]


def replace_second(
    evaluator: Evaluator,
    pair: CandidateFit,
    effects: Sequence[Effect],
    say: Say,
) -> list[CandidateFit]:
    """The pair with others in the place of its second effect, those refined
    that leave less.
    """
    exact = thresholds.TWIN_ERROR * evaluator.count
    if not effects or pair.excess <= exact:
        return []
    first, values = pair.uses[0]
    problem = CandidateProblem(evaluator, [first], [values])
    kept, solution = len(problem.scales), pair.solution
    alone = replace(
        pair,
        effects=(first,),
        values=(values,),
        scales=problem.scales,
        # Of the two; alone it is not known.
        excess=np.inf,
        solution=replace(
            solution,
            z=solution.z[:kept],
            jacobian=solution.jacobian[:, :kept],
        ),
    )
    try:
        beside = Linearisation(evaluator, alone)
    except BraceError:
        return []
    candidates = screen(beside, effects, say)
    search_best(beside, candidates, say, must_explain=True)
    found = best_fits(candidates)
    found = refine(evaluator, found, beside.remaining, most=pair.excess)
    return [f for f in refined(found) if f.excess < pair.excess]


def refine_best(
    criterion: Criterion,
    evaluator: Evaluator,
    candidates: Sequence[Candidate],
    remaining: float,
    seed: int,
    bar: float = np.inf,
) -> list[CandidateFit]:
    """Refined fits of the best pairs among candidates.

    Args:
        criterion: With its null distribution.
        evaluator: Over the fit runs.
        candidates: After their searches.
        remaining: See `shortlist.refine`.
        seed: Of places where a search that was caught begins again.
        bar: Largest excess that counts.
    """
    good = [f for f in best_fits(candidates) if f.excess <= bar]
    good = refine(evaluator, good, remaining, criterion.largest_excess(2))
    found = refined(good)
    # The nominal fit is no pair, so never caught.
    best = min(good, key=lambda f: f.excess, default=criterion.nominal)
    if is_caught(criterion, best):
        found += restart(evaluator, best, seed)
    return found


def is_caught(criterion: Criterion, pair: CandidateFit) -> bool:
    """Whether a pair of few parameters takes most of the gap, and yet leaves
    more than two effects may.

    What drives leave that stick is no kink, and their search is dear.
    """
    if pair.is_flexible or len(pair.effects) < 2 or not pair.is_searched:
        return False
    if pair.sticks:
        return False
    enough = criterion.closed(pair) >= criterion.least_share
    return enough and not criterion.explains(pair)


def restart(
    evaluator: Evaluator, fit: CandidateFit, seed: int
) -> list[CandidateFit]:
    """The search again from places near its end, up to three of them.

    A limit, a gap or a stop has a kink where it is reached, and a search over
    two effects and the subject may be caught beside it.

    Args:
        evaluator: Over the fit runs.
        fit: Where a search stands, of few parameters.
        seed: Of the places.

    Returns:
        The first fit that leaves less than half as much, if any does.
    """
    rng = np.random.default_rng([seed, 11])
    for _ in range(thresholds.RESTARTS):
        again = try_refine(evaluator, _moved(fit, rng))
        if again.refined and again.excess < thresholds.ESCAPED * fit.excess:
            return [again]
    return []


def _moved(fit: CandidateFit, rng: np.random.Generator) -> CandidateFit:
    def factors(count: int, size: float) -> np.ndarray:
        return np.exp(size * rng.standard_normal(count))

    subject = fit.subject * factors(
        len(fit.subject), thresholds.RESTART_SUBJECT
    )
    values = []
    for effect, mine in fit.uses:
        moved, free = mine.copy(), effect.is_continuous
        moved[free] *= factors(int(free.sum()), thresholds.RESTART_EFFECTS)
        values.append(moved)
    return replace(fit, subject=subject, values=tuple(values), refined=False)

"""A second effect beside dozens of parameters that went astray to cover it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_effects
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection.decision import refined
from brace_drake.selection.measures import is_exact
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.screening import line_up, race
from brace_drake.selection.search.shortlist import best_fits, refine

# What a second effect has to promise to leave, of what the leader leaves and
# what its parameters cost.
_PROMISED = 0.5
# Others that promise to leave at most this many times as much take its place.
_CONTENDER = 1.5


def strays(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Single effects of parameters drawn alike that leave too much or are no
    draw, best first.
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


def lead_back(
    evaluator: Evaluator,
    leader: CandidateFit,
    cards: Sequence[Effect],
    say: Callable[[str, float], None],
) -> list[CandidateFit]:
    """The leader with the second effect that promises most, refined.

    The right one makes the leader's parameters a draw again: what they cost
    counts too. From where they have gone no way leads back, so that both set
    out afresh.

    Args:
        evaluator: Over the fit runs.
        leader: One of `strays`.
        cards: Second effects.
        say: Progress, shares of this search.

    Returns:
        That fit, before it others of second effects that promised about as
        much and leave less; none where nothing promises enough.
    """
    try:
        beside = Ground(evaluator, leader, with_prior=True)
    except BraceError:
        return []
    runners = []
    for card in cards:
        say(f"cause {leader.name}+{card.key}", 0.3)
        runners += line_up(beside, card)
    best = min(runners, key=lambda r: r.promise, default=None)
    usual = leader.num_prior
    if best is None or (
        best.promise - usual > _PROMISED * (beside.there - usual)
    ):
        return []
    (first, _), (second, values) = best.problem.split(best.z)[1]
    say(f"cause {leader.name}+{second.key}", 0.6)
    try:
        pair = fit_effects(evaluator, (first, second), (first.off(), values))
    except (BraceError, ValueError):
        return []
    bar = usual + _CONTENDER * max(0.0, best.promise - usual)
    good = [r.card for r in runners if r.promise <= bar]
    others = {card.key: card for card in good if card is not second}
    rivals = replace_second(
        evaluator,
        pair,
        list(others.values()),
        lambda what, share: say(what, 0.6 + 0.4 * share),
    )
    return [*rivals, pair]


def replace_second(
    evaluator: Evaluator,
    pair: CandidateFit,
    cards: Sequence[Effect],
    say: Callable[[str, float], None],
) -> list[CandidateFit]:
    """The pair with others in the place of its second effect, those refined
    that leave less.
    """
    if not cards or is_exact(evaluator, pair):
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
        beside = Ground(evaluator, alone)
    except BraceError:
        return []
    found = best_fits(race(beside, cards, say, must_explain=True))
    found = refine(evaluator, found, beside.there, most=pair.excess)
    return [f for f in refined(found) if f.excess < pair.excess]

"""A second effect beside dozens of parameters that went astray to cover it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.errors import BraceError
from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.contenders import best_fits, try_refine
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.ground import Ground
from brace_drake.gap.screen import line_up, race
from brace_drake.gap.verdict import refined

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
        and f.solution.jacobian is not None
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
    (first, _), second = best.problem.split(best.z)[1]
    say(f"cause {leader.name}+{second[0].key}", 0.6)
    afresh = replace(
        best.fit(),
        subject=np.array([p.nominal for p in evaluator.twin.subject]),
        values=(first.off(), second[1]),
        spread=None,
    )
    pair = try_refine(evaluator, afresh)
    bar = usual + _CONTENDER * max(0.0, best.promise - usual)
    near = {r.card.key: r.card for r in runners if r.promise <= bar}
    near.pop(second[0].key)
    others = replace_second(evaluator, pair, list(near.values()), say)
    return [*others, pair]


def replace_second(
    evaluator: Evaluator,
    pair: CandidateFit,
    cards: Sequence[Effect],
    say: Callable[[str, float], None],
) -> list[CandidateFit]:
    """The pair with others in the place of its second effect, those refined
    that leave less.
    """
    if not (cards and pair.refined):
        return []
    solution = pair.solution
    kept = len(pair.subject) + int(pair.effects[0].is_continuous.sum())
    alone = replace(
        pair,
        effects=pair.effects[:1],
        values=pair.values[:1],
        scales=pair.scales[:kept],
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
    good = [f for f in found if f.excess < pair.excess]
    return refined([try_refine(evaluator, f) for f in good])

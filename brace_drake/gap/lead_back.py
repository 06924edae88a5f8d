"""A second effect beside dozens of parameters that went astray to cover it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.errors import BraceError
from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.contenders import try_refine
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.ground import Ground
from brace_drake.gap.screen import line_up

# What a second effect has to promise to leave, of what the leader leaves and
# what its parameters cost.
_PROMISED = 0.5


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
        One fit, or none where nothing promises enough.
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
    return [try_refine(evaluator, afresh)]

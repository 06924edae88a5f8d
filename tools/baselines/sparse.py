"""Sparse regression: orthogonal matching pursuit over all signatures.

The signature that takes most of what is left joins those before it, all are
fitted anew (Pati, Rezaiifar, Krishnaprasad, Asilomar Conference 1993; columns
that belong together join together). It ends where no other takes a good part
of what is left. Block and effect are read off what has joined.
"""

from __future__ import annotations

from tools.baselines.case import Case
from tools.baselines.linear import LEVEL, Linear, LinearFit
from tools.baselines.repair import answer_of

_MOST = 3
# Share of what is left above the level that one more has to take.
_WORTH = 0.5


def answer(case: Case) -> dict:
    """The signatures that have joined."""
    linear = Linear(case)
    if linear.misfit <= LEVEL:
        return answer_of(linear, None, 1.0)
    best, second = None, None
    for number in range(_MOST):
        found = _joined(linear, best)
        left = linear.misfit if best is None else best.misfit
        if not found or found[0].misfit > (1.0 - _WORTH) * left:
            # The first is taken for the block alone.
            best = best or (found[0] if found else None)
            break
        best = found[0]
        if number == 0:
            others = (f for f in found if f.names != best.names)
            second = next(others, None)
        if best.misfit <= LEVEL:
            break
    return answer_of(linear, best, _probability(linear, best, second))


def _joined(linear: Linear, best: LinearFit | None) -> list[LinearFit]:
    """One more signature beside those that are there, best first."""
    there = () if best is None else best.signatures
    fits = [
        linear.fit([*there, s])
        for s in linear.case.signatures
        if not any(s.effect.is_alike(t.effect) for t in there)
    ]
    return sorted((f for f in fits if f), key=lambda f: f.misfit)


def _probability(linear, best, second) -> float:
    """The first atom's share of both in what is left without them."""
    if best is None or second is None:
        return 1.0
    first = linear.fit(best.signatures[:1]) or best
    left = max(first.misfit, 0.0) + LEVEL, max(second.misfit, 0.0) + LEVEL
    return float(left[1] / (left[0] + left[1]))

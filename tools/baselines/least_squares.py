"""Least squares with every effect linearised, and BIC over singles and pairs.

Each signature is fitted beside the subject, alone and with each other one. The
least BIC names the effects; its weights are the probabilities.
"""

from __future__ import annotations

import itertools

import numpy as np

from tools.baselines.case import Case
from tools.baselines.linear import LEVEL, Linear, LinearFit
from tools.baselines.repair import answer_of

# Pairs are made of so many best starts of each effect.
_STARTS = 2


def answer(case: Case) -> dict:
    """The effects of least BIC."""
    linear = Linear(case)
    if linear.misfit <= LEVEL:
        return answer_of(linear, None, 1.0)
    fits = all_fits(linear)
    scores = np.array([linear.bic(fit) for fit in (None, *fits)])
    weights = np.exp(-0.5 * (scores - scores.min()))
    best = (None, *fits)[int(np.argmin(scores))]
    if best is None:
        return answer_of(linear, None, float(weights[0] / weights.sum()))
    alike = [f.names == best.names for f in fits]
    share = float(weights[1:][alike].sum() / weights.sum())
    return answer_of(linear, best, share)


def all_fits(linear: Linear) -> list[LinearFit]:
    """Each signature alone, and pairs of the better starts."""
    singles = [linear.fit([s]) for s in linear.case.signatures]
    singles = sorted((f for f in singles if f), key=linear.bic)
    kept: dict[str, list[LinearFit]] = {}
    for fit in singles:
        mine = kept.setdefault(fit.signatures[0].effect.key, [])
        if len(mine) < _STARTS:
            mine.append(fit)
    few = [f.signatures[0] for mine in kept.values() for f in mine]
    pairs = [
        linear.fit([a, b])
        for a, b in itertools.combinations(few, 2)
        if not a.effect.is_alike(b.effect)
    ]
    return [*singles, *(pair for pair in pairs if pair)]

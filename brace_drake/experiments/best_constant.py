"""The best constant stiffness: what a policy has to beat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.parallel import Workers
from brace_drake.experiments.rollouts import Arena, Contestant
from brace_drake.learning.subjects import Subject

_GRID = 9
_ROUNDS = 3
_INSIDE = 3
# Nearer than this part of the range, in its logarithm, is the end itself.
_AT_END = 0.01


@dataclass(frozen=True)
class Search:
    """A search over one stiffness.

    Attributes:
        best: N/m.
        total: Mean return with it.
        tried: The grid over the whole range, N/m.
        totals: Mean return of each of these.
        at_upper: Whether the best is the upper end of the range.
    """

    best: float
    total: float
    tried: tuple[float, ...]
    totals: tuple[float, ...]
    at_upper: bool


def search_constant(
    arena: Arena, subjects: Sequence[Subject], workers: Workers
) -> Search:
    """The constant stiffness of PIC with the largest mean return.

    A grid over the range of the policies, even in its logarithm, then a finer
    one between the neighbours of the best, and so on.
    """
    law = arena.law
    grid = np.geomspace(law.lower, law.upper, _GRID)

    def mean_returns(values) -> list[float]:
        players = [Contestant("", "pic", stiffness=float(K)) for K in values]
        tasks = [(arena, c, s) for c in players for s in subjects]
        flat = np.array(workers.map(_return_of, tasks))
        return flat.reshape((len(players), -1)).mean(axis=1).tolist()

    totals = mean_returns(grid)
    known = dict(zip(grid.tolist(), totals, strict=True))
    for _ in range(_ROUNDS):
        order = sorted(known)
        i = order.index(max(order, key=known.get))
        low, high = order[max(0, i - 1)], order[min(len(order) - 1, i + 1)]
        finer = np.geomspace(low, high, _INSIDE + 2)[1:-1]
        finer = [K for K in finer.tolist() if K not in known]
        known |= dict(zip(finer, mean_returns(finer), strict=True))
    best = max(known, key=known.get)
    span = np.log(law.upper / law.lower)
    return Search(
        best=best,
        total=known[best],
        tried=tuple(grid.tolist()),
        totals=tuple(totals),
        at_upper=bool(np.log(law.upper / best) < _AT_END * span),
    )


def _return_of(arena: Arena, contestant: Contestant, subject: Subject) -> float:
    return arena.run(contestant, subject).total

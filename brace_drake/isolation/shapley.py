"""Shares of blocks in what they achieve together, as rows of a budget.

Shapley values: the mean of what a player adds to a coalition over all orders
of joining (Shapley, A value for n-person games, Contributions to the Theory of
Games II, 1953). What nobody achieves stays as a share of its own, so that all
shares add up to 1.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from math import factorial

import numpy as np

from brace_drake.core.block_bootstrap import interval_of

UNEXPLAINED = "none of these"


def shapley_values(values: dict[frozenset[int], float], n: int) -> np.ndarray:
    """Shapley values of a game of n players.

    phi_i = sum over S without i of |S|! (n - |S| - 1)! / n!
            (v(S + i) - v(S)).

    Args:
        values: v of every coalition, the empty one included.
        n: Number of players, numbered from 0.
    """
    out = np.zeros(n)
    for coalition, value in values.items():
        for i in set(range(n)) - coalition:
            size = len(coalition)
            weight = factorial(size) * factorial(n - size - 1) / factorial(n)
            out[i] += weight * (values[coalition | {i}] - value)
    return out


def coalitions(n: int) -> list[frozenset[int]]:
    """All of them, smaller ones first."""
    return [
        frozenset(c)
        for size in range(n + 1)
        for c in itertools.combinations(range(n), size)
    ]


def share_rows(
    blocks: Sequence[str],
    shares_of: Callable[[np.ndarray], np.ndarray | None],
    pieces: int,
    seed: list[int],
    alone: Sequence[float],
    imitators: Mapping[int, Sequence[str]],
) -> list[dict]:
    """Rows of a budget by block, last what none of them explains.

    Args:
        blocks: Names of the players.
        shares_of: From how often each piece of time counts to the shares of
            the blocks and, last, of none (n + 1,); None without a gap.
        pieces: Number of pieces of time.
        seed: Of the bootstrap over them.
        alone: What each block takes by itself, and none (n + 1,).
        imitators: By place, blocks that would do as well as this one.
    """
    shares = shares_of(np.ones(pieces))
    low, high = interval_of(shares_of, pieces, seed)
    return [
        {
            "block": block,
            "share": float(shares[i]),
            "lower95": float(low[i]),
            "upper95": float(high[i]),
            "alone": float(alone[i]),
            "or": list(imitators.get(i, ())),
        }
        for i, block in enumerate((*blocks, UNEXPLAINED))
    ]

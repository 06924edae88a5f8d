"""Shares of players in what they achieve together."""

from __future__ import annotations

import itertools
from math import factorial

import numpy as np

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

"""The closed-loop gap shared out over blocks by their possible small errors.

The game. Players are the blocks. Each block may err: its output may be off by
any combination of low powers of its own inputs, their signs and fading
memory, and slow functions of time (`laws.loop.disturbance`); the twin's loop
answers each such error with a known change of all channels. The value v(S) of
a coalition S is the part of the gap of the fitted nominal twin, the weighted
sum of squares above the floor over the fit runs, that disappears when the
blocks in S may err as suits best and the subject's parameters follow (linear
least squares). Fits and ranking of causes do not enter; of the library only
the laws of elastic legs and displaced anchors do, as errors of the mechanism.

Limits. The answers are those of small errors: of a large gap, many times the
floor, errors of actuation, mechanism and force reading imitate one another,
and the intervals, which resample time, do not hold that doubt.

Errors of several blocks together can imitate those of another one. So the
blocks that take part are the fewest that do: each further one has to explain
at least `_PRICE` of the gap, and more than all of them together leave, for a
description that is itself no better proves nothing finer. Among these the
shares are Shapley values, the mean of what a block adds to v over all orders
of joining (Shapley 1953; least squares: Lindeman, Merenda and Gold 1980,
Groemping 2007). What no block explains stays as a share of its own: all of
them add up to 1.

Source: Groemping, The American Statistician 61, 2007.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brace_drake.isolation.shapley import (
    coalitions,
    shapley_values,
    share_rows,
)

# Part of the gap that a further block has to explain.
_PRICE = 0.015
_HIGHEST_PRICE = 0.1
# Coalitions that explain this much less of the gap are as good.
_TIED = 0.015
_RIDGE = 1e-9


class Moments(NamedTuple):
    """Products of the gap and of what may explain it, piece by piece of time.

    Attributes:
        blocks: Names of the players.
        owner: Of each column: -2 the residual itself, -1 the subject, else
            the index of a block (P,).
        pieces: Products of columns over each piece of time (n, P, P).
        counts: Independent values in each piece (n,), what noise alone gives.
    """

    blocks: tuple[str, ...]
    owner: np.ndarray
    pieces: np.ndarray
    counts: np.ndarray


def gather(
    blocks: Sequence[str], owner: Sequence[int], series: Sequence[np.ndarray]
) -> Moments:
    """Moments of runs in time.

    Args:
        blocks: Names of the players.
        owner: Of each column, see `Moments`.
        series: For each piece of time (P, N, C), whitened.
    """
    flat = [np.reshape(s, (len(s), -1)) for s in series]
    return Moments(
        tuple(blocks),
        np.array(owner),
        np.array([s @ s.T for s in flat]),
        np.array([s.shape[1] for s in flat], dtype=float),
    )


def explained_shares(
    moments: Moments, weights: np.ndarray | None = None
) -> dict[frozenset[int], float] | None:
    """v(S) of every coalition; None without a gap.

    Args:
        moments: The products.
        weights: How often each piece of time counts (n,); all once if None.
    """
    weights = np.ones(len(moments.pieces)) if weights is None else weights
    gram = np.tensordot(weights, moments.pieces, 1)
    count = float(weights @ moments.counts)
    gram, owner = _profiled(gram, moments.owner)
    gap = gram[0, 0] - count
    if gap <= 0.0:
        return None
    out = {}
    for coalition in coalitions(len(moments.blocks)):
        inside = np.flatnonzero(np.isin(owner, list(coalition)))
        out[coalition] = min(1.0, _explained(gram, inside) / gap)
    return _never_falling(out)


def _never_falling(values: dict) -> dict:
    """Least v that no joining block makes smaller: noise apart, it does not."""
    out: dict[frozenset[int], float] = {}
    for coalition, value in values.items():
        smaller = [out[coalition - {i}] for i in coalition]
        out[coalition] = max([value, *smaller])
    return out


def _profiled(gram: np.ndarray, owner: np.ndarray):
    """Products left once the subject follows, columns scaled to 1."""
    subject = owner == -1
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    scaled = gram / np.outer(scale, scale)
    inner = scaled[np.ix_(subject, subject)]
    inner = inner + _RIDGE * np.eye(len(inner))
    cross = scaled[np.ix_(subject, ~subject)]
    left = scaled[np.ix_(~subject, ~subject)]
    if len(inner):
        left = left - cross.T @ np.linalg.solve(inner, cross)
    # The residual keeps its size; the other columns' does not matter.
    left[0] *= scale[0]
    left[:, 0] *= scale[0]
    return left, owner[~subject]


def _explained(gram: np.ndarray, inside: np.ndarray) -> float:
    """Sum of squares that columns explain, less what noise lets them."""
    diagonal = np.diag(gram)
    inside = inside[diagonal[inside] > 100.0 * _RIDGE]
    if not len(inside):
        return 0.0
    size = np.sqrt(diagonal[inside])
    inner = gram[np.ix_(inside, inside)] / np.outer(size, size)
    target = gram[inside, 0] / size
    inner = inner + _RIDGE * np.eye(len(inside))
    solution = np.linalg.solve(inner, target)
    return max(0.0, float(target @ solution) - len(inside))


def fewest(
    values: dict[frozenset[int], float], settled: frozenset[int] | None = None
) -> frozenset[int]:
    """The coalition that explains most at the price of its members.

    Args:
        values: v of every coalition.
        settled: One that is kept unless another is clearly better.
    """

    price = min(max(_PRICE, 1.0 - max(values.values())), _HIGHEST_PRICE)

    def worth(s):
        return values[s] - price * len(s) + price * (s == settled)

    return max(values, key=worth)


def shares_of(
    values: dict[frozenset[int], float],
    n: int,
    settled: frozenset[int] | None = None,
) -> np.ndarray:
    """Share of each block, and at the end what none explains (n + 1,)."""
    members = sorted(fewest(values, settled))
    inner = {
        s: values[frozenset(members[i] for i in s)]
        for s in coalitions(len(members))
    }
    out = np.zeros(n + 1)
    out[members] = shapley_values(inner, len(members))
    out[n] = 1.0 - values[frozenset(members)]
    return out


def imitators(values: dict[frozenset[int], float]) -> dict[int, list[int]]:
    """For each block of the fewest, the others that would do as well.

    A block that can be exchanged for another one is not proven: the smallest
    provable segment is the two of them.
    """
    chosen = fewest(values)
    n = max((i for s in values for i in s), default=-1) + 1
    limit = values[chosen] - max(_TIED, 0.5 * (1.0 - values[chosen]))
    out = {}
    for i in sorted(chosen):
        others = set(range(n)) - chosen
        out[i] = [
            j for j in sorted(others) if values[(chosen - {i}) | {j}] >= limit
        ]
    return out


def attribute(moments: Moments, seed: int) -> list[dict]:
    """Rows of the budget by block; their shares add up to 1.

    Args:
        moments: The products.
        seed: Of the bootstrap over pieces of time.

    Returns:
        Block, share, 95 % interval, and under `or` the blocks that the data
        cannot tell from it; last what none explains. Empty without a gap.
    """
    values, blocks = explained_shares(moments), moments.blocks
    if values is None:
        return []
    settled = fewest(values)

    def shares(weights):
        drawn = explained_shares(moments, weights)
        return drawn and shares_of(drawn, len(blocks), settled)

    alone = [values[frozenset({i})] for i in range(len(blocks))]
    return share_rows(
        blocks,
        shares,
        len(moments.pieces),
        [seed, 37],
        [*alone, 1.0 - values[frozenset()]],
        {i: [blocks[j] for j in js] for i, js in imitators(values).items()},
    )

"""The gap shared out over the blocks by repairing them one after the other.

The game. Players are the blocks of the effects that explain the gap. The
value v(S) of a coalition S is the part of the gap of the fitted nominal twin,
the weighted sum of squares above the floor over the fit runs, that disappears
when the blocks in S carry their effects and the others stay nominal, with the
subject and the effects of S fitted anew: the twin itself is simulated, so that
a large gap is shared out as well as a small one. A block's share is its
Shapley value, the mean of what its repair adds over all orders of repairing;
what all repairs together leave is a share of its own, so that all of them add
up to 1.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.whitening import in_pieces
from brace_drake.isolation.shapley import (
    coalitions,
    shapley_values,
    share_rows,
)
from brace_drake.selection.search.candidate import candidate_of
from brace_drake.selection.search.linearisation import Linearisation

_STEPS = 5


def share_repairs(
    evaluator: Evaluator,
    nominal: CandidateFit,
    winner: CandidateFit,
    rivals: Sequence[str],
    seed: int,
) -> list[dict]:
    """Rows of the budget by block; their shares add up to 1.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        winner: The fit whose effects explain the gap.
        rivals: Effects, pairs joined by +, that explain it as well.
        seed: Of the bootstrap over pieces of time.

    Returns:
        Block, share, 95 % interval, what it takes alone, and under `or` the
        blocks of rivals; last what the repairs leave. None where the gap is
        no more than the noise, so that there is nothing to share.
    """
    blocks = list(dict.fromkeys(e.block for e in winner.effects))
    pieces = _excess_pieces(evaluator, nominal, winner, blocks)
    count = len(pieces[frozenset()])

    everyone = frozenset(range(len(blocks)))

    def shares(weights):
        gap = float(weights @ pieces[frozenset()])
        if gap <= 0.0:
            return None
        taken = {
            coalition: float(np.clip(1.0 - weights @ excess / gap, 0.0, 1.0))
            for coalition, excess in pieces.items()
        }
        left = 1.0 - taken[everyone]
        return np.append(shapley_values(taken, len(blocks)), left)

    gap = float(pieces[frozenset()].sum())
    if gap <= 0.0:
        return []
    alone = [
        float(np.clip(1.0 - pieces[frozenset({i})].sum() / gap, 0.0, 1.0))
        for i in range(len(blocks))
    ]
    left = float(np.clip(pieces[everyone].sum() / gap, 0.0, 1.0))
    cards = evaluator.twin.effects().values()
    named = set(itertools.chain.from_iterable(r.split("+") for r in rivals))
    others = dict.fromkeys(c.block for c in cards if c.cause in named)
    return share_rows(
        blocks,
        shares,
        count,
        [seed, 43],
        [*alone, left],
        {0: [b for b in others if b not in blocks]},
    )


def _excess_pieces(
    evaluator, nominal, winner, blocks
) -> dict[frozenset[int], np.ndarray]:
    """Squares above noise of every coalition, piece by piece of time (n,)."""
    found = {}
    for coalition in coalitions(len(blocks)):
        residual, noise = nominal.solution.residual, 1.0
        if len(coalition) == len(blocks):
            residual = winner.solution.residual
            noise = evaluator.noise_level(winner.uses)
        elif coalition:
            kept = [blocks[i] for i in coalition]
            residual, noise = _repaired_in(evaluator, nominal, winner, kept)
        pieces = in_pieces(evaluator, residual[: evaluator.ends[-1]])
        found[coalition] = np.array(
            [np.sum(p**2) - noise * np.count_nonzero(p) for p in pieces]
        )
    return found


def _repaired_in(
    evaluator, nominal, winner, blocks
) -> tuple[np.ndarray, float]:
    """Residual with the winner's effects of these blocks alone, refitted, and
    the mean square of noise in it.
    """
    uses = tuple((e, v) for e, v in winner.uses if e.block in blocks)
    base = Linearisation(evaluator, nominal)
    starts = [
        candidate_of(base, uses, subject, winner.spread)
        for subject in (nominal.subject, winner.subject)
    ]
    starts = [r for r in starts if r is not None]
    if not starts:
        return nominal.solution.residual, 1.0
    best = min(starts, key=lambda r: r.residual @ r.residual)
    best.step(base, _STEPS)
    return best.residual, evaluator.noise_level(uses, coarse=True)

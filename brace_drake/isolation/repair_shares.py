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

Source: Shapley, A value for n-person games, Contributions to the Theory of
Games II, 1953.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.effects.registry import effects_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.whitening import in_time
from brace_drake.isolation.shapley import (
    UNEXPLAINED,
    coalitions,
    shapley_values,
)
from brace_drake.selection.search.candidate import make_candidate
from brace_drake.selection.search.linearisation import Linearisation

_PIECE_S = 1.0
_RESAMPLES = 300
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
    if pieces[frozenset()].sum() <= 0.0:
        return []
    shares, alone = _shares(pieces, np.ones(len(pieces[frozenset()])), blocks)
    draws = _resampled(pieces, blocks, seed)
    low, high = np.quantile(np.vstack([draws, shares]), [0.025, 0.975], axis=0)
    others = _blocks_of(evaluator, rivals)
    rows = [
        {
            "block": block,
            "share": float(shares[i]),
            "lower95": float(low[i]),
            "upper95": float(high[i]),
            "alone": float(alone[i]),
            "or": [b for b in others if b not in blocks] if i == 0 else [],
        }
        for i, block in enumerate([*blocks, UNEXPLAINED])
    ]
    return rows


def _blocks_of(evaluator, rivals) -> list[str]:
    cards = effects_for(evaluator.twin.device).values()
    block = {card.name: card.block for card in cards}
    names = itertools.chain.from_iterable(r.split("+") for r in rivals)
    return list(dict.fromkeys(block[n] for n in names if n in block))


def _excess_pieces(evaluator, nominal, winner, blocks) -> dict:
    """Squares above noise of every coalition, piece by piece of time (n,)."""
    everyone = frozenset(range(len(blocks)))
    residuals = {
        frozenset(): (nominal.solution.residual, 1.0),
        everyone: (
            winner.solution.residual,
            evaluator.noise_level(winner.uses),
        ),
    }
    for coalition in coalitions(len(blocks)):
        if coalition not in residuals:
            kept = [blocks[i] for i in coalition]
            residuals[coalition] = _repaired_in(
                evaluator, nominal, winner, kept
            )
    return {
        s: _pieces(evaluator, residual[: evaluator.ends[-1]], noise)
        for s, (residual, noise) in residuals.items()
    }


def _repaired_in(
    evaluator, nominal, winner, blocks
) -> tuple[np.ndarray, float]:
    """Residual with the winner's effects of these blocks alone, refitted, and
    the mean square of noise in it.
    """
    kept = [
        (e, v)
        for e, v in zip(winner.effects, winner.values, strict=True)
        if e.block in blocks
    ]
    effects, values = zip(*kept, strict=True)
    base = Linearisation(evaluator, nominal)
    starts = [
        make_candidate(base, effects, values, subject, winner.spread)
        for subject in (nominal.subject, winner.subject)
    ]
    starts = [r for r in starts if r is not None]
    if not starts:
        return nominal.solution.residual, 1.0
    best = min(starts, key=lambda r: r.residual @ r.residual)
    best.step(base, _STEPS)
    uses = tuple(zip(effects, values, strict=True))
    return best.residual, evaluator.noise_level(uses, coarse=True)


def _pieces(
    evaluator: Evaluator, residual: np.ndarray, noise: float
) -> np.ndarray:
    """Squares above noise of that mean square over pieces of time of all
    runs.
    """
    out = []
    edges = itertools.pairwise([0, *evaluator.ends])
    for run, (begin, end) in zip(evaluator.prepared, edges, strict=True):
        series = in_time(run, residual[begin:end])
        duration = run.run.time_s[-1] - run.run.time_s[0]
        parts = np.array_split(series, max(1, round(duration / _PIECE_S)))
        out += [float(np.sum(p**2)) - noise * p.size for p in parts]
    return np.array(out)


def _shares(pieces, weights, blocks) -> tuple[np.ndarray, np.ndarray]:
    """Shares and what each takes alone, what is left behind (n + 1,)."""
    gap = float(weights @ pieces[frozenset()])
    everyone = frozenset(range(len(blocks)))
    taken = {
        s: float(np.clip(1.0 - weights @ excess / gap, 0.0, 1.0))
        for s, excess in pieces.items()
    }
    left = 1.0 - taken[everyone]
    alone = [taken[frozenset({i})] for i in range(len(blocks))]
    shares = shapley_values(taken, len(blocks))
    return np.append(shares, left), np.append(alone, left)


def _resampled(pieces, blocks, seed) -> np.ndarray:
    """Shares over resampled pieces of time (draws, blocks + 1)."""
    generator = np.random.default_rng([seed, 43])
    n, draws = len(pieces[frozenset()]), []
    for _ in range(_RESAMPLES):
        weights = generator.multinomial(n, np.full(n, 1.0 / n)).astype(float)
        if weights @ pieces[frozenset()] > 0.0:
            draws.append(_shares(pieces, weights, blocks)[0])
    return np.array(draws).reshape(len(draws), len(blocks) + 1)

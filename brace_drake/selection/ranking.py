"""The order of explanations, and how explanations that are tied are told apart.

What an explanation leaves and how many effects it needs make its score. Those
of as many effects that are tied by it, as a gain of the drives and a scale of
the force reading may be, leave the same but need other values of the numbers
that are known to a tolerance, and of parameters that have a prior: the prior
density of these says which is the likelier. Every other parameter that is
fitted costs one in its log likelihood (Akaike, A new look at the
statistical model identification, IEEE Trans. Automatic Control 19, 1974).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion

# Degrees of freedom of Student's distribution of numbers.
_FREEDOM = thresholds.ODDS * thresholds.TAIL - 1.0


class Ranked(NamedTuple):
    """A fit and its score once ties are broken."""

    fit: CandidateFit
    score: float


def rank(criterion: Criterion, fits: Sequence[CandidateFit]) -> list[Ranked]:
    """Of refined fits that name the same effects, whatever their form, the
    best, and their scores, best first. Those whose many parameters are no draw
    from one law are none.

    Where a verdict is decided and even the best leaves an unknown law, that has
    stretched numbers too: then what they are stretched to counts for none.
    """
    best: dict[frozenset[str], CandidateFit] = {}
    known = [f for f in fits if f.may_win]
    for fit in sorted(known, key=criterion.score):
        best.setdefault(criterion.named(fit), fit)
    ranked = [Ranked(f, criterion.score(f)) for f in best.values()]
    ranked = _without_ties(criterion, ranked)
    decides = criterion.is_last and not criterion.is_foreign
    if decides and ranked and criterion.is_material(ranked[0].fit):
        return rank(replace(criterion, is_foreign=True), fits)
    return ranked


def best_of_kinds(
    criterion: Criterion, fits: Sequence[CandidateFit]
) -> list[CandidateFit]:
    """The fits of `rank`."""
    return [r.fit for r in rank(criterion, fits)]


def _without_ties(criterion: Criterion, ranked: list[Ranked]) -> list[Ranked]:
    """Those that are tied with the best, and have as many effects, ordered and
    set apart by what their numbers cost.
    """
    if not ranked:
        return []
    least = ranked[0].score
    number = criterion.num_effects(ranked[0].fit)
    tied, others = [], []
    for r in ranked:
        is_near = r.score - least < thresholds.TIED
        is_alike = criterion.num_effects(r.fit) == number
        (tied if is_near and is_alike else others).append(r)
    if len(tied) == 1:
        return ranked
    # What one leaves more is no reason to think less of its numbers; and what
    # is left of an unknown law moves numbers too.
    left = max(r.fit.excess for r in tied)
    known = min(criterion.known(r.fit) for r in tied)
    costs = [
        r.score
        + known * prior_cost(r.fit, left)
        + parameter_cost(criterion.findings(r.fit))
        for r in tied
    ]
    apart = [
        Ranked(r.fit, least + cost - min(costs))
        for r, cost in zip(tied, costs, strict=True)
    ]
    return sorted([*apart, *others], key=lambda r: r.score)


def parameter_cost(effects: Sequence[Effect]) -> float:
    """One for each of their parameters that is fitted and has no prior, over
    `ODDS`, as of a score.
    """
    own = (e.is_continuous.sum() for e in effects if not e.is_flexible)
    return float(sum(own)) / thresholds.ODDS


def prior_cost(fit: CandidateFit, left: float) -> float:
    """Minus the logarithm of the prior density of a fit's numbers, as of a
    score.

    Each has Student's distribution, (nu + 1) / 2 ln(1 + t^2 / nu) over `ODDS`
    at t deviations.

    Args:
        fit: One that was searched.
        left: Sum of squares above noise, all of which may lie along numbers
            known to a tolerance.
    """
    rows = len(fit.solution.residual) - fit.num_prior
    off, known = fit.solution.residual[rows:], fit.tolerances
    if known is not None:
        noise = 1.0 + max(0.0, left) / len(known.nuisances)
        along = known.along(fit.solution.residual[:rows])
        off = np.append(off, known.estimate(along, noise))
    return float(0.5 * thresholds.TAIL * np.sum(np.log1p(off**2 / _FREEDOM)))

"""The causes of a gap, ranked by the criterion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict
from brace_drake.selection.ranking import rank
from brace_drake.validation.prediction import Prediction


@dataclass(frozen=True)
class Cause:
    """A candidate and what was decided of it.

    Attributes:
        fit: Of the candidate.
        score: Of the criterion, less is better; None where it was not led to
            its end.
        prediction: What it leaves on validation runs, None where not replayed.
        is_tied: Whether the data cannot tell it from the winner.
        decision: In words.
    """

    fit: CandidateFit
    score: float | None
    prediction: Prediction | None
    is_tied: bool
    decision: str


def one_of_each(
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    winner: CandidateFit | None,
) -> list[CandidateFit]:
    """Of fits of the same effects, in whatever order, the one that was led
    furthest, and of those the best; the winner in any case.
    """

    def place(fit):
        order = criterion.score(fit) if fit.refined else fit.excess
        return fit is not winner, not fit.refined, not fit.is_searched, order

    best: dict[frozenset[str], CandidateFit] = {}
    for fit in sorted(fits, key=place):
        best.setdefault(frozenset(e.key for e in fit.effects), fit)
    return list(best.values())


def rank_causes(
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    verdict: Verdict,
    predictions: Sequence[Prediction],
) -> list[Cause]:
    """The winner, then by score those led to their end, then those that were
    searched, then those that were only screened.

    Args:
        criterion, fits, verdict: Of the search and its decision.
        predictions: Of validation runs.
    """
    scores = {
        id(r.fit): r.score for r in rank(criterion, [criterion.nominal, *fits])
    }
    ranked = []
    for fit in fits:
        is_winner = fit is verdict.winner
        seen = next((p for p in predictions if p.fit is fit), None)
        named = "+".join(e.cause for e in criterion.findings(fit))
        is_tied = named in verdict.ambiguous_with
        score = criterion.score(fit) if fit.refined else None
        # Once ties are broken.
        score = scores.get(id(fit), score)
        decision = _decision(criterion, fit, verdict, is_tied)
        order = score if score is not None else criterion.misfit(fit)
        place = not is_winner, not fit.refined, not fit.is_searched, order
        ranked.append((place, Cause(fit, score, seen, is_tied, decision)))
    ranked.sort(key=lambda pair: pair[0])
    return [cause for _, cause in ranked]


def _decision(criterion, fit, verdict, is_tied) -> str:
    if fit is verdict.winner:
        return "explains the gap" if verdict.gap else "is within tolerances"
    if not verdict.gap:
        return "no gap to explain"
    if not fit.is_searched:
        return "screened only: one replay predicted less than others"
    if is_tied:
        return "as good as the first on these data"
    if not fit.is_scattered:
        return "its many parameters do not look like a draw"
    rest = np.sqrt(1.0 + max(0.0, criterion.misfit(fit)))
    text = f"leaves {rest:.1f} times the floor on the fit runs"
    if fit.held_out is not None:
        rest = np.sqrt(1.0 + criterion.predicted(fit))
        text += f", {rest:.1f} on motions not seen"
    return text

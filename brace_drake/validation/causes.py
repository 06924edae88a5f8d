"""The causes of a gap, ranked by what they leave on motions not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import effects_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict
from brace_drake.selection.surrogate_data import surrogate_gains
from brace_drake.validation.held_out import held_out_misfit
from brace_drake.validation.prediction import Prediction


@dataclass(frozen=True)
class Cause:
    """A candidate and what was decided of it.

    Attributes:
        fit: Of the candidate.
        held_out: What it leaves on fit runs left out in turn, see
            `held_out_misfit`.
        surrogates: How many surrogates it was compared with, the share of the
            gap that it takes, and that the best of them does; None where it
            was not compared in earnest.
        prediction: What it leaves on validation runs, None where not replayed.
        is_tied: Whether the data cannot tell it from the winner.
        decision: In words.
    """

    fit: CandidateFit
    held_out: float | None
    surrogates: tuple[int, float, float] | None
    prediction: Prediction | None
    is_tied: bool
    decision: str


def rank_causes(
    evaluator: Evaluator,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    verdict: Verdict,
    predictions: Sequence[Prediction],
    seed: int,
) -> list[Cause]:
    """The winner, then by what they leave on motions that they have not seen;
    then pairs of which one effect does as well, then who was not searched.

    Args:
        evaluator: Over the fit runs.
        criterion, fits, verdict: Of the search and its decision.
        predictions: Of validation runs.
        seed: Of the surrogates.
    """
    gap = criterion.misfit(criterion.nominal)
    ranked = []
    for fit in fits:
        is_winner = fit is verdict.winner
        part = None if is_winner else criterion.part_as_good(fit, fits)
        held_out = held_out_misfit(evaluator, fit)
        seen = next((p for p in predictions if p.fit is fit), None)
        surrogates = None
        if gap > 0.0 and (is_winner or seen):
            taken = surrogate_gains(evaluator, criterion.nominal, fit, seed)
            if taken.size:
                own = criterion.gain(fit, criterion.nominal)
                surrogates = len(taken), own / gap, float(taken[-1]) / gap
        is_tied = "+".join(fit.identifiers) in verdict.ambiguous_with
        decision = _decision(criterion, fit, verdict, is_tied, part)
        left = criterion.misfit(fit) if held_out is None else held_out
        rank = not is_winner, not fit.is_searched, part is not None, left
        cause = Cause(fit, held_out, surrogates, seen, is_tied, decision)
        ranked.append((rank, cause))
    ranked.sort(key=lambda pair: pair[0])
    return [cause for _, cause in ranked]


def _decision(criterion, fit, verdict, is_tied, part) -> str:
    if fit is verdict.winner:
        return "explains the gap"
    if not verdict.gap:
        return "no gap to explain"
    if is_tied:
        return "as good as the first on these data"
    if part is not None:
        return f"leaves as much as {part.name} alone"
    if not criterion.gains(fit, criterion.nominal):
        return "gains no more than noise would"
    if not fit.is_scattered:
        return "its many parameters do not look like a draw"
    rest = 1.0 + max(0.0, criterion.misfit(fit))
    return f"leaves {np.sqrt(rest):.1f} times the floor on the fit runs"


def untried_at_rest(device: str, fits: Sequence[CandidateFit]) -> list[Effect]:
    """Effects that would show at rest and were not tried, as nothing does."""
    tried = {e.name for fit in fits for e in fit.effects}
    cards = effects_for(device).values()
    return [c for c in cards if c.at_rest and c.name not in tried]

"""Validation has the last word: what it contradicts is not announced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import (
    RunComparison,
    is_repaired,
    rms_gap,
)
from brace_drake.recording.recording import Campaign, Run
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict, contradict, decide
from brace_drake.selection.thresholds import BEYOND_LEVEL
from brace_drake.validation.shrinkage import compare_new_runs
from brace_drake.validation.support import Closed, closed_by_each


def without_copies(campaign: Campaign) -> tuple[list[Run], tuple[str, ...]]:
    """Validation runs that are new, and the names of those that repeat a fit
    run to the last digit: these confirm nothing.
    """
    fitted = [run.channels for run in campaign.split("fit")]
    new, copies = [], []
    for run in campaign.split("validation"):
        is_copy = any(_are_same(run.channels, other) for other in fitted)
        if is_copy:
            copies.append(run.name)
        else:
            new.append(run)
    return new, tuple(copies)


def _are_same(first, second) -> bool:
    common = [n for n in first if n in second and n != "time_s"]
    return bool(common) and all(
        np.array_equal(first[n], second[n], equal_nan=True) for n in common
    )


class Confirmation(NamedTuple):
    """What validation runs leave of a verdict.

    Attributes:
        verdict: Without what they contradict.
        compared: Those runs, before and after its repair; none where there
            are none.
        closed: What each effect that is still named closes by itself.
    """

    verdict: Verdict
    compared: list[RunComparison]
    closed: dict[str, Closed]


def confirm(
    validation: Evaluator,
    criterion: Criterion,
    verdict: Verdict,
    fits: Sequence[CandidateFit],
    seed: int,
) -> Confirmation:
    """Holds a verdict against runs that no fit has seen.

    An effect that makes them worse beside the others is withdrawn by itself,
    the worst first. What stays has to make them better, and no gap has to be
    none there.

    Args:
        validation: Over those runs.
        criterion, verdict, fits: Of the fit runs.
        seed: Of the intervals.
    """
    while True:
        compared = compare_new_runs(
            validation, criterion.nominal, verdict.winner
        )
        closed = closed_by_each(
            validation, criterion, verdict, fits, compared, seed
        )
        judged = _judge(criterion, verdict, fits, compared, closed)
        if judged is verdict:
            return Confirmation(verdict, compared, closed)
        verdict = judged


def _judge(criterion, verdict, fits, compared, closed) -> Verdict:
    """The verdict less what is contradicted first; itself where nothing is."""
    if not compared:
        return verdict
    repaired = is_repaired(compared)
    before = rms_gap(compared, "before")
    after = rms_gap(compared, "after") if repaired else before
    if verdict.effects and repaired:
        worse = [n for n, c in closed.items() if c.is_harm]
        if worse and len(closed) > 1:
            name = min(worse, key=lambda n: closed[n].share)
            reason = _harm_text(verdict, name, closed[name])
            return withdraw(criterion, verdict, fits, name, reason)
        if not after < before:
            return contradict(
                verdict,
                _all_reasons(
                    verdict,
                    f"on the validation runs {' and '.join(verdict.effects)}"
                    f" would change the gap from {before:.3g} to {after:.3g}"
                    " times the floor",
                ),
            )
    # More than what is left on the fit runs, as a gap is more than the level.
    misfit = criterion.misfit(verdict.winner or criterion.nominal)
    left = max(0.0, misfit - criterion.least) + criterion.level
    most = np.sqrt(1.0 + BEYOND_LEVEL * left)
    if not verdict.gap and after > most:
        return contradict(
            verdict,
            f"the validation runs are {after:.3g} times the floor off, the fit"
            " runs are not",
        )
    return verdict


def withdraw(
    criterion: Criterion,
    verdict: Verdict,
    fits: Sequence[CandidateFit],
    name: str,
    reason: str,
) -> Verdict:
    """The verdict without one of its effects, decided anew among explanations
    by the others; nothing that was not named before is named.

    Args:
        criterion, verdict, fits: Of the fit runs.
        name: Of the effect.
        reason: In words.
    """
    kept = {*verdict.effects} - {name}
    able = [f for f in fits if criterion.named(f) <= kept]
    reason = _all_reasons(verdict, reason)
    left = decide(criterion, able)
    if not left.effects:
        return contradict(verdict, reason)
    # What was held for right before is known to be wrong.
    sure = min(verdict.probability, 1.0 - verdict.probability)
    sure = min(left.probability, sure)
    return replace(left, probability=sure, contradicted=reason)


def _harm_text(verdict: Verdict, name: str, closed: Closed) -> str:
    block = next(e.block for e in verdict.winner.effects if e.cause == name)
    low, high = (100.0 * end for end in closed.interval)
    return (
        f"{name} ({block}) makes the validation runs worse: it closes"
        f" {100.0 * closed.share:.1f} % of their gap, 95 % of {low:.1f} to"
        f" {high:.1f} %"
    )


def _all_reasons(verdict: Verdict, reason: str) -> str:
    return "; ".join(r for r in (verdict.contradicted, reason) if r)

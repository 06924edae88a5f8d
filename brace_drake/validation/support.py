"""What each named effect closes by itself, on runs that no fit has seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from brace_drake.core.errors import BraceError
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import (
    RunComparison,
    interval_of_rms,
    is_repaired,
    rms_gap,
)
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.validation.shrinkage import repair_new_runs


@dataclass(frozen=True)
class Closed:
    """Share of the gap that comes back where one effect is left out.

    At most all of it: the twin that has none of the effects lacks it too.

    Attributes:
        share: Of what lies between the gap and the floor.
        interval: 95 %, by resampling blocks of time; None without.
    """

    share: float
    interval: tuple[float, float] | None

    @property
    def is_harm(self) -> bool:
        """Whether the effect opens the gap instead, beyond doubt."""
        return self.interval is not None and self.interval[1] < 0.0


def closed_by_each(
    validation: Evaluator,
    criterion: Criterion,
    verdict: Verdict,
    fits: Sequence[CandidateFit],
    compared: Sequence[RunComparison],
    seed: int,
) -> dict[str, Closed]:
    """Of each named effect, by validation runs; by the fit runs where there
    are none, where the twin without it breaks down, or where there is none.

    Args:
        validation: Over runs that no fit has seen.
        criterion, verdict, fits: Of the search and its decision.
        compared: Those runs, before and after the repair.
        seed: Of the intervals.
    """
    ranked = best_of_kinds(criterion, fits)
    found = {}
    for support in verdict.supported:
        others = criterion.named(verdict.winner) - {support.name}
        same = (f for f in ranked if criterion.named(f) == others)
        without = next(same, None)
        found[support.name] = Closed(support.closes, None)
        if not is_repaired(compared) or (others and without is None):
            continue
        which, runs = "before", list(compared)
        if without is not None:
            try:
                runs = repair_new_runs(validation, compared, without)
            except BraceError:
                continue
            which = "after"
        found[support.name] = _between(compared, runs, which, seed)
    return found


def _between(compared, runs, which: str, seed: int) -> Closed:
    """How far the repair brings runs on, from where one effect lacks."""

    def share(whole, lacks, after):
        lacks = min(lacks, whole)
        return (lacks - after) / (whole - 1.0) if whole > 1.0 else None

    gaps = (
        rms_gap(compared, "before"),
        rms_gap(runs, which),
        rms_gap(compared, "after"),
    )
    squares = [
        [c.squares("before") for c in compared],
        [c.squares(which) for c in runs],
        [c.squares("after") for c in compared],
    ]
    interval = interval_of_rms(compared, squares, seed, share)
    return Closed(share(*gaps) or 0.0, interval)

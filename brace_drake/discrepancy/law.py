"""A law of what no effect of the library explains, and what it closes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Device
from brace_drake.discrepancy.search import LawSearch
from brace_drake.effects.unknown import is_term
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import (
    RunComparison,
    compare_runs,
    is_repaired,
    rms_gap,
)
from brace_drake.identification.intervals import (
    EstimateTable,
    estimate_table,
)
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.screening import Say, silent
from brace_drake.selection.settle import set_within
from brace_drake.validation.shrinkage import (
    measure_shrinkage,
    repair_new_runs,
)


@dataclass(frozen=True)
class FoundLaw:
    """Terms that describe an unknown effect, fitted in the closed loop.

    Attributes:
        fit: With the terms, beside the effects that are named.
        estimates: Parameters of that fit, with their errors.
        shrinkage: How far the gap shrinks with all of them on runs that no
            fit has seen; None without such runs.
        runs: Of both splits, replayed before and after.
    """

    fit: CandidateFit
    estimates: EstimateTable
    shrinkage: dict | None
    runs: tuple[RunComparison, ...] = ()

    @property
    def blocks(self) -> list[str]:
        """Of its terms."""
        found = (e.block for e in self.fit.effects if is_term(e))
        return list(dict.fromkeys(found))


def find_law(
    device: Device,
    laws: LawSearch,
    validation: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    compared: Sequence[RunComparison],
    seed: int,
    say: Say = silent,
) -> FoundLaw | None:
    """The law of what a fit leaves; None where no law holds.

    Terms of all blocks compete: where a law holds, it tells the block.

    Args:
        device: Of the campaign.
        laws: Of what fits of the campaign leave.
        validation: Over runs held back.
        criterion: Of the campaign.
        base: With the effects that are named, or the nominal fit.
        compared: Runs held back, before and after the base's repair.
        seed: Of the intervals.
        say: Progress.
    """
    evaluator = laws.evaluator
    fit = laws.beside(criterion, base, say)
    if fit is base:
        return None
    fit = set_within(evaluator, fit, device.uses_off)
    repaired: list[RunComparison] = []
    try:
        if compared:
            repaired = repair_new_runs(validation, compared, fit)
    except BraceError:
        # Its twin breaks down on runs that no fit has seen.
        return None
    if compared and not _left(repaired) < _left(compared):
        return None
    shrinkage = measure_shrinkage(
        device, repaired, criterion.nominal.subject, seed
    )
    fitted = compare_runs(evaluator, criterion.nominal, fit)
    estimates = estimate_table(evaluator, fit, seed)
    return FoundLaw(fit, estimates, shrinkage, (*repaired, *fitted))


def _left(compared: Sequence[RunComparison]) -> float:
    """The gap with what repairs it, without where nothing does."""
    return rms_gap(compared, "after" if is_repaired(compared) else "before")

"""A law of what no effect of the library explains, and what it closes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from brace_drake.devices.declaration import Device
from brace_drake.discrepancy.search import search_law
from brace_drake.effects.card import Effect
from brace_drake.effects.unknown import is_term, terms_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import RunComparison, is_repaired, rms_gap
from brace_drake.identification.intervals import (
    EstimateTable,
    estimate_table,
)
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.screening import Say, silent
from brace_drake.selection.settle import set_within
from brace_drake.validation.shrinkage import (
    compare_new_runs,
    measure_shrinkage,
)


@dataclass(frozen=True)
class FoundLaw:
    """Terms that describe an unknown effect, fitted in the closed loop.

    Attributes:
        fit: With the terms, beside the effects that are named.
        estimates: Parameters of that fit, with their errors.
        shrinkage: How far the gap shrinks with all of them on runs that no
            fit has seen; None without such runs.
        compared: Those runs, before and after.
    """

    fit: CandidateFit
    estimates: EstimateTable
    shrinkage: dict | None
    compared: list[RunComparison]

    @property
    def terms(self) -> list[Effect]:
        """Of the law, the first found first."""
        return [e for e in self.fit.effects if is_term(e)]


def find_law(
    device: Device,
    evaluator: Evaluator,
    validation: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    blocks: Sequence[str],
    seed: int,
    say: Say = silent,
) -> FoundLaw | None:
    """The law of what a fit leaves; None where no law holds.

    Terms of the accused blocks alone are tried.

    Args:
        device: Of the campaign.
        evaluator, validation: Over fit runs and runs held back.
        criterion: Of the campaign.
        base: With the effects that are named, or the nominal fit.
        blocks: In which the gap lies.
        seed: Of the intervals.
        say: Progress.
    """
    known = terms_for(device.twin.device).values()
    terms = [t for t in known if t.block in blocks]
    if not terms:
        return None
    fit = search_law(evaluator, criterion, base, terms, say)
    if fit is base:
        return None
    fit = set_within(evaluator, fit, device.uses_off)
    compared = compare_new_runs(validation, criterion.nominal, fit)
    if _is_refuted(validation, criterion, base, compared):
        return None
    shrinkage = measure_shrinkage(
        device, compared, criterion.nominal.subject, seed
    )
    estimates = estimate_table(evaluator, fit, seed)
    return FoundLaw(fit, estimates, shrinkage, compared)


def _is_refuted(
    validation: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    compared: Sequence[RunComparison],
) -> bool:
    """Whether runs that no fit has seen are not better with the law."""
    if not compared:
        return False
    if not is_repaired(compared):
        return True
    named = base if base.effects else None
    before = compare_new_runs(validation, criterion.nominal, named)
    which = "after" if named is not None and is_repaired(before) else "before"
    return not rms_gap(compared, "after") < rms_gap(before, which)

"""Validation has the last word: what it contradicts is not announced."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.identification.gap import (
    RunComparison,
    is_repaired,
    rms_gap,
)
from brace_drake.recording.recording import Campaign, Run
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict, contradict
from brace_drake.selection.thresholds import BEYOND_LEVEL


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


def confirm(
    criterion: Criterion, verdict: Verdict, compared: Sequence[RunComparison]
) -> Verdict:
    """The verdict, withdrawn where runs that no fit has seen contradict it.

    Effects have to make those runs better, and no gap has to be none there.

    Args:
        criterion: Of the campaign.
        verdict: From the fit runs.
        compared: Validation runs before and after the repair; none where there
            are none.
    """
    if not compared:
        return verdict
    before = rms_gap(compared, "before")
    if verdict.effects and is_repaired(compared):
        after = rms_gap(compared, "after")
        if not after < before:
            return contradict(
                verdict,
                f"on the validation runs {' and '.join(verdict.effects)} would"
                f" change the gap from {before:.3g} to {after:.3g} times the"
                " floor",
            )
    most = np.sqrt(1.0 + BEYOND_LEVEL * criterion.level)
    if not verdict.gap and before > most:
        return contradict(
            verdict,
            f"the validation runs are {before:.3g} times the floor off, the fit"
            " runs are not",
        )
    return verdict

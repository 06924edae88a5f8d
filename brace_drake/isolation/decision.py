"""Which block a gap lies in that no effect of the library explains."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.criterion import Criterion, refined
from brace_drake.selection.decision import Verdict
from brace_drake.selection.thresholds import MATERIAL


def accused_blocks(
    verdict: Verdict,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    tests: Sequence[dict],
    law: Sequence[str] = (),
) -> list[str]:
    """Blocks in which the gap lies: those of the effects named and, where what
    is left is material, the one in which that lies.

    A law of what is left tells its block, as terms of all blocks have competed.
    Without one it is what the tests of the blocks suspect.

    Args:
        verdict: Of the diagnosis.
        criterion, fits: Of the search.
        tests: Rows of `run_block_tests`.
        law: Blocks of the law that was found of what is left.
    """
    if not verdict.gap:
        return []
    found: list[str] = []
    if verdict.winner is not None:
        block = {e.cause: e.block for e in verdict.winner.effects}
        found = [block[name] for name in verdict.effects]
    found += law
    if verdict.outside_library and not found:
        found = nearest_block(criterion, fits) or suspected_blocks(tests)
    return list(dict.fromkeys(found))


def nearest_block(
    criterion: Criterion, fits: Sequence[CandidateFit]
) -> list[str]:
    """The block of a single effect that takes by far most of the gap.

    It is not what happens, its parameters being no draw or its rest too large,
    but what happens acts like it.
    """
    singles = [f for f in refined(fits) if len(f.effects) == 1]
    return [
        fit.effects[0].block
        for fit in singles[:1]
        if criterion.closed(fit) >= 1.0 - 2.0 * MATERIAL
    ]


def suspected_blocks(tests: Sequence[dict]) -> list[str]:
    """The block with the largest share of what is above its threshold; where
    all are within their thresholds, as tolerances widen them, the nearest.

    The controller is exact and is never suspected.

    Args:
        tests: Rows of `run_block_tests`.
    """

    def nearness(row: dict) -> float:
        """What is above the floor, over what may be."""
        return (row["normalised_rms"] - 1.0) / (row["threshold"] - 1.0)

    known = [r for r in tests if r["block"] != "controller"]
    known.sort(key=lambda r: (r["share"], nearness(r)))
    return [r["block"] for r in known[-1:]]

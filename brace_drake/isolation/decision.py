"""Which block a gap lies in that no effect of the library explains."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.effects.card import ANSWER_MOTION
from brace_drake.identification.fits import CandidateFit
from brace_drake.isolation.force_balance import DRIVES, RING, suspected_part
from brace_drake.selection.criterion import Criterion, refined
from brace_drake.selection.decision import Verdict
from brace_drake.selection.thresholds import MATERIAL


def accused_blocks(
    verdict: Verdict,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    tests: Sequence[dict],
    where: dict,
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
        where: From `locate_gap`.
        law: Blocks of the law that was found of what is left.
    """
    if not verdict.gap:
        return []
    found: list[str] = []
    if verdict.winner is not None:
        block = {e.name: e.block for e in verdict.winner.effects}
        found = [block[name] for name in verdict.effects]
    found += law
    if verdict.outside_library and not found:
        found = nearest_block(criterion, fits) or suspected_blocks(
            tests,
            where["balance"],
            where["contact_side"],
            where["attribution"],
        )
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


def suspected_blocks(
    tests: Sequence[dict],
    balance: Sequence[dict],
    imposed: dict | None = None,
    attribution: Sequence[dict] = (),
) -> list[str]:
    """The block with the largest share of what is above its threshold.

    If all blocks are within their thresholds, as tolerances widen them, it is
    the block whose small errors take most of the gap in closed loop, where
    tolerances are told apart; if none does, the block nearest to its threshold.
    The controller is exact and is never suspected. Contact, torso and reading
    are cleared if together they match the recording on the recorded trajectory
    of the ring. Contact and torso are cleared if they are less beyond their
    threshold than drives and ring.

    Args:
        tests: Rows of `run_block_tests`.
        balance: Rows of `explain_imbalance`, none where the device has no
            such balance.
        imposed: Row of what answers to an imposed motion as a whole, None
            where it was not looked at.
        attribution: Rows of `attribute_errors`.
    """

    def nearness(row: dict) -> float:
        """What is above the floor, over what may be."""
        return (row["normalised_rms"] - 1.0) / (row["threshold"] - 1.0)

    known = [r for r in tests if r["block"] != "controller"]
    machine = [r for r in known if r["block"] in (DRIVES, RING)]
    if imposed is not None:
        beyond = max((nearness(r) for r in machine), default=0.0)
        if machine and imposed["acquitted"]:
            known = machine
        elif machine and nearness(imposed) < beyond:
            known = [r for r in known if r["block"] not in ("contact", "torso")]
        else:
            known = [r for r in known if r["block"] in ANSWER_MOTION]
    if not known:
        return []
    if all(r["acquitted"] for r in known):
        taken = {r["block"]: r["share"] for r in attribution}
        nearest = max(known, key=lambda r: taken.get(r["block"], 0.0))
        if taken.get(nearest["block"], 0.0) > 0.0:
            return [nearest["block"]]
    block = max(known, key=lambda r: (r["share"], nearness(r)))["block"]
    return [suspected_part(balance) if block == DRIVES else block]

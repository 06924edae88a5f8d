"""Which block a gap lies in that no effect of the library explains."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.isolation import imposed_motion as contact_side
from brace_drake.isolation.force_balance import DRIVES, RING, suspected_part


def suspected_blocks(
    ladder: Sequence[dict],
    balance: Sequence[dict],
    side: dict | None = None,
) -> list[str]:
    """The block with the largest share of what is above its threshold.

    Where all are within theirs, as of a gap of about the noise, the one that
    is nearest to it. The controller, which is exact, is none. Where the
    contact's side as a whole holds on the recorded way of the ring, or is less
    beyond its threshold than drives and ring, contact and torso are none.

    Args:
        ladder: Rows of `ladder.climb`.
        balance: Rows of `balance.explain_imbalance`, none where the device has
            no such balance.
        side: Row of the contact's side as a whole, None where it was not
            looked at.
    """
    known = [r for r in ladder if r["block"] != "controller"]
    if side is not None:
        known = _on_one_side(known, side)
    if not known:
        return []
    block = max(known, key=_suspicion)["block"]
    return [suspected_part(balance) if block == DRIVES else block]


def _on_one_side(rows: list[dict], side: dict) -> list[dict]:
    """The rows of the side of the machine that the gap is on."""
    machine = [r for r in rows if r["block"] in (DRIVES, RING)]
    beyond = max((_nearness(r) for r in machine), default=0.0)
    if machine and (side["acquitted"] or _nearness(side) < beyond):
        return [r for r in rows if r["block"] not in ("contact", "torso")]
    return [r for r in rows if r["block"] in contact_side.BLOCKS]


def _suspicion(row: dict) -> tuple[float, float]:
    return row["share"], _nearness(row)


def _nearness(row: dict) -> float:
    """What is above the floor, over what may be."""
    return (row["normalised_rms"] - 1.0) / (row["threshold"] - 1.0)

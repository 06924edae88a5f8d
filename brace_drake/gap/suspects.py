"""Which block a gap lies in that no effect of the library explains."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.gap import contact_side

# The balance of the leg forces holds neither where drives do not give what
# they are told, nor where something else pulls at the ring, nor with a wrong
# reading of its force. The ring is named where errors of its own explain this
# share of the gap and those of the drives less, or leave by far less.
_BY_FAR, _BY_FAR_LESS = 0.95, 2.0 / 3.0
# The reading, where drives and ring explain next to nothing of what it does: a
# force that is there moves the ring.
_NOTHING = 0.1
_DRIVES, _RING, _READING = "actuation", "mechanism", "sensing"


def suspected_blocks(
    ladder: Sequence[dict],
    attribution: Sequence[dict],
    side: dict | None = None,
) -> list[str]:
    """The block with the largest share of what is above its threshold.

    Where all are within theirs, as of a gap of about the noise, the one that
    is nearest to it. The controller, which is exact, is none. Where the
    contact's side as a whole holds on the recorded way of the ring, or is less
    beyond its threshold than drives and ring, contact and torso are none.

    Args:
        ladder: Rows of `ladder.climb`.
        attribution: Rows of the device's attribution by errors of the blocks,
            none where it has none.
        side: Row of the contact's side as a whole, None where it was not
            looked at.
    """
    known = [r for r in ladder if r["block"] != "controller"]
    if side is not None:
        known = _on_one_side(known, side)
    if not known:
        return []
    block = max(known, key=_suspicion)["block"]
    if block == _DRIVES:
        block = _out_of_balance({r["block"]: r["alone"] for r in attribution})
    return [block]


def _on_one_side(rows: list[dict], side: dict) -> list[dict]:
    """The rows of the side of the machine that the gap is on."""
    machine = [r for r in rows if r["block"] in (_DRIVES, _RING)]
    beyond = max((_nearness(r) for r in machine), default=0.0)
    if machine and (side["acquitted"] or _nearness(side) < beyond):
        return [r for r in rows if r["block"] not in ("contact", "torso")]
    return [r for r in rows if r["block"] in contact_side.BLOCKS]


def _out_of_balance(alone: dict[str, float]) -> str:
    """Which of drives, ring and reading the balance does not hold for.

    Args:
        alone: Share of the gap that errors of each block explain.
    """
    drives, ring = alone.get(_DRIVES, 0.0), alone.get(_RING, 0.0)
    if max(drives, ring) < _NOTHING * alone.get(_READING, 0.0):
        return _READING
    if ring > drives:
        if ring > _BY_FAR or 1.0 - ring < _BY_FAR_LESS * (1.0 - drives):
            return _RING
    return _DRIVES


def _suspicion(row: dict) -> tuple[float, float]:
    return row["share"], _nearness(row)


def _nearness(row: dict) -> float:
    """What is above the floor, over what may be."""
    return (row["normalised_rms"] - 1.0) / (row["threshold"] - 1.0)

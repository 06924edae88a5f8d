"""Which block a gap lies in that no effect of the library explains."""

from __future__ import annotations

from collections.abc import Sequence

# The balance of the leg forces holds neither where drives do not give what
# they are told, nor where something else pulls at the ring. The ring is named
# where errors of its own explain this share of the gap and those of the
# drives less.
_BY_FAR = 0.95
_DRIVES, _RING = "actuation", "mechanism"


def suspected_blocks(
    ladder: Sequence[dict], attribution: Sequence[dict]
) -> list[str]:
    """The block with the largest share of what is above its threshold.

    Where all are within theirs, as of a gap of about the noise, the one that
    is nearest to it. The controller, which is exact, is none.

    Args:
        ladder: Rows of `ladder.climb`.
        attribution: Rows of the device's attribution by errors of the blocks,
            none where it has none.
    """
    known = [r for r in ladder if r["block"] != "controller"]
    if not known:
        return []
    block = max(known, key=_suspicion)["block"]
    alone = {r["block"]: r["alone"] for r in attribution}
    if block == _DRIVES and _RING in alone:
        if alone[_RING] > max(_BY_FAR, alone[_DRIVES]):
            block = _RING
    return [block]


def _suspicion(row: dict) -> tuple[float, float]:
    near = (row["normalised_rms"] - 1.0) / (row["threshold"] - 1.0)
    return row["share"], near

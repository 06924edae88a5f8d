"""Whose errors an inverse-dynamics residual shows: drives, ring or reading.

Forces are in balance neither where drives do not give what they are told, nor
where something else pulls at the ring, nor with a wrong reading of its force.
Which it is the shape of the residual along the recorded way tells: few errors
of the right block take nearly all of it. Each block's errors are chosen one by
one, what takes most first (orthogonal matching pursuit: Pati, Rezaiifar and
Krishnaprasad, Asilomar Conference 1993), at most `_TERMS` of them, so that a
block with many errors to choose from gains little by that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device, Term
from brace_drake.identification.evaluation import PreparedRun

DRIVES, RING, READING = "actuation", "mechanism", "sensing"
_TERMS = 3
# Share of the imbalance with which a description of it is whole.
_WHOLE = 0.99
# What a block's errors leave if it is named, and of what others leave.
_LITTLE, _LESS = 0.1, 0.5
# What is left is known to, as the noise is.
_KNOWN_TO = 0.01
# Relative length of a shape that others have almost made.
_MADE = 5e-2


def suspected_part(rows: Sequence[dict]) -> str:
    """Which of drives, ring and reading an imbalance is laid to.

    The drives, unless errors of ring or reading take nearly all of it and leave
    less than half of what those of the drives do; then the ring, unless the
    reading leaves less than half of what the ring does.

    Args:
        rows: From `explain_imbalance`; without any nothing is known.
    """
    left = {r["block"]: max(1.0 - r["explained"], _KNOWN_TO) for r in rows}
    drives, ring, reading = (
        left.get(block, 1.0) for block in (DRIVES, RING, READING)
    )
    if min(ring, reading) > min(_LITTLE, _LESS * drives):
        return DRIVES
    return READING if reading < _LESS * ring else RING


def explain_imbalance(
    device: Device,
    prepared: Sequence[PreparedRun],
    drives: dict,
) -> list[dict]:
    """How much of the imbalance few errors of each block take.

    Args:
        device: Whose forces are looked at.
        prepared: Runs; those that tell nothing are left out.
        drives: Row of the block test that weighs the imbalance against noise.

    Returns:
        A row for drives, ring and reading each: `explained`, the share of the
        imbalance beyond noise that three errors take (0 to 1), and `errors`
        with their sizes, as many of them as describe it whole. None where the
        imbalance is within what noise makes, or nothing is there to tell it
        from.
    """
    if drives["acquitted"]:
        return []
    found = [device.force_balance(p) for p in prepared]
    parts = [part for part in found if part is not None]
    if not parts:
        return []
    lack = np.concatenate([lack for lack, _ in parts])
    noise = lack @ lack / drives["normalised_rms"] ** 2
    rows = []
    for block in (DRIVES, RING, READING):
        titles, units, shapes = _join([terms[block] for _, terms in parts])
        chosen, left = _pursue(shapes, lack)
        shares = 1.0 - (left - noise) / (lack @ lack - noise)
        share = float(np.clip(shares[-1], 0.0, 1.0)) if chosen else 0.0
        # What an error adds to a description that is whole is no part of it.
        chosen = chosen[: 1 + int(np.sum(shares[:-1] < _WHOLE))]
        sizes = np.linalg.lstsq(shapes[:, chosen], -lack, rcond=None)[0]
        rows.append(
            {
                "block": block,
                "explained": share,
                "errors": [
                    {"title": titles[i], "size": float(s), "unit": units[i]}
                    for i, s in zip(chosen, sizes, strict=True)
                ],
            }
        )
    return rows


def _join(
    parts: Sequence[Sequence[Term]],
) -> tuple[list[str], list[str], np.ndarray]:
    """Titles and units of errors, and their shapes over all runs (M, P)."""
    units = {t.title: t.unit for terms in parts for t in terms}
    columns: dict[str, list[np.ndarray]] = {title: [] for title in units}
    for terms in parts:
        known = {t.title: t.shape for t in terms}
        nothing = np.zeros(len(terms[0].shape))
        for title, column in columns.items():
            column.append(known.get(title, nothing))
    shapes = np.stack([np.concatenate(c) for c in columns.values()], axis=1)
    return list(units), list(units.values()), shapes


def _pursue(
    shapes: np.ndarray, lack: np.ndarray
) -> tuple[list[int], np.ndarray]:
    """Columns of (M, P) that take most of (M,), one by one, and the squares
    that are left after each.
    """
    size = np.linalg.norm(shapes, axis=0)
    rest = np.divide(shapes, size, out=np.zeros_like(shapes), where=size > 0.0)
    left, chosen, squares = lack.copy(), [], []
    for _ in range(_TERMS):
        length = np.linalg.norm(rest, axis=0)
        usable = length > _MADE
        if not usable.any():
            break
        taken = np.zeros(len(length))
        np.divide(np.abs(rest.T @ left), length, out=taken, where=usable)
        best = int(np.argmax(taken))
        direction = rest[:, best] / length[best]
        left = left - direction * (direction @ left)
        rest = rest - np.outer(direction, direction @ rest)
        chosen.append(best)
        squares.append(left @ left)
    return chosen, np.array(squares)

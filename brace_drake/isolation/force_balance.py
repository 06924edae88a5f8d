"""Whose errors the balance of the leg forces shows: drives, ring or reading.

The balance holds neither where drives do not give what they are told, nor where
something else pulls at the ring, nor with a wrong reading of its force. Which
it is the shape of the imbalance along the recorded way tells: few errors of the
right block take nearly all of it. Each block's errors are chosen one by one,
what takes most first (orthogonal matching pursuit: Pati, Rezaiifar and
Krishnaprasad, Asilomar Conference 1993), at most `_TERMS` of them, so that a
block with many errors to choose from gains little by that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.bench.force_balance import (
    CUTOFF_HZ,
    MARGIN_S,
    calc_imbalance,
    follow_ring,
)
from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.bench.rollout import COMMANDS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.isolation.force_balance_terms import (
    Term,
    drive_terms,
    reading_terms,
    ring_terms,
)

DRIVES, RING, READING = "actuation", "mechanism", "sensing"
# Of the signals that errors are made of.
_SIGNAL_HZ = 15.0
# Samples that are compared, a bit more than the low pass leaves of them.
_COMPARED_HZ = 20.0
_TERMS = 3
# Share of the imbalance with which a description of it is whole.
_WHOLE = 0.99
# What a block's errors leave if it is named, and of what others leave.
_LITTLE, _LESS = 0.1, 0.5
# What is left is known to, as the noise is.
_KNOWN_TO = 0.01
# Relative length of a shape that a moment of the torso's could have, and of one
# that others have almost made.
_MOMENT, _MADE = 1e-2, 5e-2


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
    twin: BenchTwin,
    prepared: Sequence[PreparedRun],
    rate: float,
    drives: dict,
) -> list[dict]:
    """How much of the imbalance few errors of each block take.

    Args:
        twin: Whose nominal numbers count.
        prepared: Runs; those without commands or of less than a second are
            left out.
        rate: Of the recordings, Hz.
        drives: Row of the ladder that weighs the imbalance against noise.

    Returns:
        A row for drives, ring and reading each: `explained`, the share of the
        imbalance beyond noise that three errors take (0 to 1), and `errors`
        with their sizes, as many of them as describe it whole. None where the
        imbalance is within what noise makes, or nothing is there to tell it
        from.
    """
    if drives["acquitted"]:
        return []
    has = twin.channels[COMMANDS]
    parts = [_compare(twin, p, rate) for p in prepared if p.run.has(has).all()]
    parts = [(lack, terms) for lack, terms in parts if len(lack)]
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


def _compare(
    twin: BenchTwin, prepared: PreparedRun, rate: float
) -> tuple[np.ndarray, dict[str, list[Term]]]:
    """What the balance of a run lacks (M,), and errors of each block, in terms
    of the root of their number: each run counts as it does in the ladder.
    """
    numbers, x = twin.numbers, prepared.measured
    touches = prepared.run.contact
    gravity = numbers.ring[4] / numbers.ring[0]
    way = follow_ring(numbers, x, rate, CUTOFF_HZ)
    lack = calc_imbalance(numbers, way, touches)
    # The errors' own corners lie above the low pass, which comes last.
    signals = follow_ring(numbers, x, rate, _SIGNAL_HZ)
    edge, every = int(MARGIN_S * rate), max(1, int(rate / _COMPARED_HZ))

    def cut(values):
        inner = values[edge : max(edge, len(values) - edge) : every].ravel()
        return inner / np.sqrt(max(1, len(inner)))

    def see(shape):
        """An error as it shows in what the balance lacks."""
        slow = low_pass(shape, CUTOFF_HZ, rate)
        if not touches:
            return cut(slow)
        seen = way.beyond_moments(slow)
        is_moment = np.linalg.norm(seen) < _MOMENT * np.linalg.norm(slow)
        return cut(np.zeros_like(seen) if is_moment else seen)

    def slow(terms):
        return [Term(t.title, t.unit, see(t.shape)) for t in terms]

    return cut(lack), {
        DRIVES: slow(drive_terms(signals)),
        RING: slow(ring_terms(signals, gravity)),
        READING: slow(reading_terms(signals, touches)),
    }


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

"""Samples that a recorder lost, and how they are put back."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

# A straight line stands in for this many samples in a row, and for this share
# of a recording; more would be invention.
_LONGEST = 5
_LARGEST_SHARE = 0.1


def can_fill(missing: np.ndarray) -> bool:
    """Whether lost samples are so few and short that lines stand in for them.

    Args:
        missing: Marks of all samples, the lost ones included (N,), bool.
    """
    if np.mean(missing) > _LARGEST_SHARE:
        return False
    edges = np.diff(missing.astype(int), prepend=0, append=0)
    lengths = np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
    return bool(lengths.max(initial=0) <= _LONGEST)


def lost_rows(time: np.ndarray) -> np.ndarray:
    """Marks of the samples that have no row, among all of them (M,), bool.

    All are marked, as no line could stand in, where more than half were lost.

    Args:
        time: Rising sample times (N,), s.
    """
    steps = np.diff(time)
    if len(steps) == 0 or np.any(steps <= 0.0):
        return np.zeros(len(time), dtype=bool)
    with np.errstate(over="ignore"):
        counts = np.maximum(1, np.round(steps / np.median(steps)))
        if not counts.sum() < 2 * len(time):
            return np.ones(len(time), dtype=bool)
    counts = counts.astype(int)
    missing = np.ones(counts.sum() + 1, dtype=bool)
    missing[np.concatenate([[0], np.cumsum(counts)])] = False
    return missing


def fill_dropouts(
    columns: dict[str, np.ndarray], names: Collection[str]
) -> dict[str, np.ndarray]:
    """Columns with lost rows, and with values that are no number, on lines.

    Args:
        columns: With `time_s`.
        names: Columns to fill; others are left out where rows were lost.
    """
    lost = lost_rows(columns["time_s"])
    at, everyone = np.flatnonzero(~lost), np.arange(len(lost))
    filled = {}
    for name, values in columns.items():
        if name not in names:
            if not lost.any():
                filled[name] = values
            continue
        good = np.isfinite(values)
        if lost.any() or not good.all():
            values = np.interp(everyone, at[good], values[good])
        filled[name] = values
    return filled

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


def place_in_time(time: np.ndarray) -> np.ndarray:
    """Number of each row's sample among all, the lost ones included (N,).

    Args:
        time: Rising sample times (N,), s.
    """
    steps = np.diff(time)
    if len(steps) == 0 or np.any(steps <= 0.0):
        return np.arange(len(time))
    counts = np.maximum(1, np.round(steps / np.median(steps)))
    return np.concatenate([[0], np.cumsum(counts)]).astype(int)


def lost_rows(time: np.ndarray) -> np.ndarray:
    """Marks of the samples that have no row (M,), bool."""
    at = place_in_time(time)
    missing = np.ones(at[-1] + 1, dtype=bool)
    missing[at] = False
    return missing


def fill_dropouts(
    columns: dict[str, np.ndarray], names: Collection[str]
) -> dict[str, np.ndarray]:
    """Columns with lost rows, and with values that are no number, on lines.

    Args:
        columns: With `time_s`.
        names: Columns to fill; others are left out where rows were lost.
    """
    time = columns["time_s"]
    at = place_in_time(time)
    everyone = np.arange(at[-1] + 1)
    if len(everyone) == len(time):
        return {
            name: _on_lines(values, everyone, everyone)
            if name in names
            else values
            for name, values in columns.items()
        }
    return {
        name: _on_lines(columns[name], at, everyone)
        for name in columns
        if name in names
    }


def _on_lines(
    values: np.ndarray, at: np.ndarray, everyone: np.ndarray
) -> np.ndarray:
    good = np.isfinite(values)
    if good.all() and len(at) == len(everyone):
        return values
    return np.interp(everyone, at[good], values[good])

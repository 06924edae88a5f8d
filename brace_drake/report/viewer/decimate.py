"""Fewer points of a trace with none of its peaks lost."""

from __future__ import annotations

import numpy as np


def decimate(
    time: np.ndarray, values: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest value of each of `most / 2` pieces of equal length.

    A trace that is short enough stays as it is.

    Args:
        time: (N,), rising.
        values: (N, S); NaN where there is none.
        most: Points to be left, at least 2.

    Returns:
        Times (M,) and values (M, S), M <= most. Both values of a piece are in
        the order in which the trace passes from one to the other.
    """
    count = len(time)
    if count <= most:
        return time, values
    starts = np.linspace(0, count, max(1, most // 2) + 1).astype(int)
    first, last = starts[:-1], starts[1:] - 1
    # fmin and fmax pass over NaN unless there is nothing else.
    low = np.fmin.reduceat(values, first, axis=0)
    high = np.fmax.reduceat(values, first, axis=0)
    falls = values[last] < values[first]
    kept = np.empty((2 * len(first), values.shape[1]))
    kept[0::2] = np.where(falls, high, low)
    kept[1::2] = np.where(falls, low, high)
    times = np.empty(2 * len(first))
    times[0::2] = time[first]
    times[1::2] = time[(first + last + 1) // 2]
    return times, kept

"""Whether two runs move alike: as far, and as fast."""

from __future__ import annotations

import numpy as np

# How many times more one may change than the other, over any time.
_ALIKE = 2.0


def moves_alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether the largest changes of two motions, over 4 samples, 8, 16 and so
    on, differ by no more than a factor.

    Args:
        one, other: Positions at the same rate (N,), (M,).
    """
    shorter = min(len(one), len(other))
    lags = [2**k for k in range(2, 32) if 2**k < shorter]
    changes = np.array([_largest(one, lags), _largest(other, lags)])
    least, most = changes.min(axis=0), changes.max(axis=0)
    return bool(lags) and bool(np.all(most <= _ALIKE * least))


def _largest(way: np.ndarray, lags: list[int]) -> list[float]:
    """Largest change within each time."""
    return [float(np.abs(way[lag:] - way[:-lag]).max()) for lag in lags]

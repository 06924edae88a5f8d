"""Where a way goes on elsewhere, as no machine does."""

from __future__ import annotations

import numpy as np

# A jump is so many times the steps on both sides of it, which are steps where
# they are so many deviations of a reading.
_JUMP, _SHAKE = 3.0, 4.0


def jumps_in(way: np.ndarray, noise: float) -> np.ndarray:
    """Rows after which a way goes on elsewhere (J,).

    A way that moves has steps much like their neighbours. One that begins or
    ends to move has a larger one on one side; only a jump stands alone.

    Args:
        way: (N,).
        noise: What changes from sample to sample by itself, as a deviation.
    """
    shake = _SHAKE * noise
    steps = np.abs(np.diff(way))
    beside = np.maximum(steps[:-2], steps[2:])
    rows = 1 + np.flatnonzero(steps[1:-1] > _JUMP * (beside + shake))
    # Where it rests on both sides, it was asked to jump.
    return rows[beside[rows - 1] > shake]

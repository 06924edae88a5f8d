"""Block bootstrap: 95 % intervals by resampling pieces of time.

Errors last: a residual at one sample tells of the next. So pieces of about a
second are drawn with repetition, all that happens in one of them together.

Source: Kuensch, The jackknife and the bootstrap for general stationary
observations, Annals of Statistics 17, 1989.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

PIECE_S = 1.0
_DRAWS = 300


def pieces_of(run, series: np.ndarray, axis: int = 0) -> list[np.ndarray]:
    """A run's series, cut into pieces of time of nearly equal length."""
    duration = run.time_s[-1] - run.time_s[0]
    count = max(1, round(duration / PIECE_S))
    return np.array_split(series, count, axis=axis)


def interval_of(
    statistic: Callable[[np.ndarray], np.ndarray | float | None],
    count: int,
    seed: list[int],
    draws: int = _DRAWS,
) -> tuple[np.ndarray, np.ndarray] | None:
    """95 % interval of a statistic, with its value inside.

    Args:
        statistic: From how often each piece counts (count,) to values; None
            where there is nothing to tell.
        count: Number of pieces.
        seed: Of the draws.
        draws: Number of resamples.

    Returns:
        Lower and upper limits; None where there is nothing to tell of the
        pieces as they are.
    """
    value = statistic(np.ones(count))
    if value is None:
        return None
    generator = np.random.default_rng(seed)
    weights = generator.multinomial(
        count, np.full(count, 1.0 / count), size=draws
    )
    drawn = [statistic(w.astype(float)) for w in weights]
    drawn = [d for d in drawn if d is not None]
    low, high = np.quantile([*drawn, value], [0.025, 0.975], axis=0)
    return np.minimum(low, value), np.maximum(high, value)

"""Rates of false alarms, and what a channel's own noise is."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.special import chdtri, ndtri

# False alarms of one kind of test that a sound campaign may give.
FALSE_ALARM = 1e-4
# Root mean square that the floor of a replayed law may be off by itself:
# replicates are few, and readings between samples unknown.
_FLOOR_ERROR = 1.5
# Scatter over noise from which on there is more than noise.
_SIGNAL = 2.0
# Blocks of its length that chance may make.
_BY_CHANCE = 0.01
# Share of the steps from sample to sample that are no leap.
_USUAL = 0.99
# Of a normal sample: its deviation over the median of its absolute values.
_MAD = 1.4826
# Variance of `local_error` over that of white noise: 1 + 2 (4^2 + 1) / 6^2.
LOCAL_VARIANCE = 35.0 / 18.0


def usual_step(steps: np.ndarray) -> float:
    """What all but one in a hundred of the steps from sample to sample do not
    exceed; 0 without any.
    """
    return float(np.quantile(steps, _USUAL)) if len(steps) else 0.0


def largest_normal(number: int) -> float:
    """Deviations that not one of so many normal values exceeds, but for the
    rate of false alarms.
    """
    return float(-ndtri(0.5 * FALSE_ALARM / max(1, number)))


def largest_mean_square(count: int, number: int) -> float:
    """Mean of `count` squares of noise that none of `number` exceeds."""
    rate = FALSE_ALARM / max(1, number)
    return float(chdtri(count, rate) / count) * _FLOOR_ERROR**2


def local_error(values: np.ndarray) -> np.ndarray:
    """Each sample less the cubic through two neighbours on each side (N,).

    0 at the ends, and in any cubic; a spike shows whole.
    """
    out = np.zeros(len(values))
    if len(values) < 5:
        return out
    around = 4.0 * (values[1:-3] + values[3:-1]) - values[:-4] - values[4:]
    out[2:-2] = values[2:-2] - around / 6.0
    return out


def robust_deviation(values: np.ndarray) -> float:
    """Standard deviation of the bulk of values around 0."""
    return float(_MAD * np.median(np.abs(values)))


def noise_deviation(values: np.ndarray) -> float:
    """Standard deviation of what changes from sample to sample by itself, of
    white noise times the root of `LOCAL_VARIANCE`.
    """
    return robust_deviation(local_error(values))


def has_signal(values: np.ndarray) -> bool:
    """Whether a reading scatters more than what changes from sample to sample
    does by itself.
    """
    noise = noise_deviation(values) / np.sqrt(LOCAL_VARIANCE)
    return bool(np.std(values) > _SIGNAL * noise)


def is_noise_scaled(ratios: Sequence[float], scale: float) -> bool:
    """Whether the noise of readings is nearer to so many times the usual than
    to the usual.

    A unit enlarges the noise with the reading. Without that, any reading is
    made as small as one that hardly is there.

    Args:
        ratios: Of recorded noise over the usual, as deviations.
        scale: Of the readings; below 1 noise of writing down hides its own.
    """
    return abs(scale) < 1.0 or bool(np.median(ratios) > np.sqrt(abs(scale)))


def likeliest_lag(first: np.ndarray, second: np.ndarray) -> int:
    """Samples by which the columns of one are behind those of another, as
    their second differences resemble each other most.
    """
    total = np.zeros(2 * len(first))
    for a, b in zip(first.T, second.T, strict=True):
        a, b = np.diff(a, 2), np.diff(b, 2)
        size = float(np.std(a) * np.std(b))
        if size > 0.0:
            one, other = (np.fft.rfft(v, len(total)) for v in (a, b))
            total += np.fft.irfft(one * other.conj(), len(total)) / size
    lag = int(np.argmax(total))
    return lag if lag <= len(first) else lag - len(total)


def unlikely_blocks(lags: np.ndarray) -> list[tuple[int, int]]:
    """Begin and end of blocks of rows that equal others so far away, too long
    to be alike by chance.

    Readings that are rounded coarsely coincide now and then: chance makes
    blocks whose numbers fall geometrically with their length.

    Args:
        lags: How far away each row's equal is, 0 without (N,).
    """
    edges = np.flatnonzero(np.diff(lags, prepend=0, append=0))
    blocks = [(int(a), int(b)) for a, b in pairwise(edges) if lags[a] != 0]
    sizes = np.array([end - begin for begin, end in blocks], dtype=int)
    singles = np.count_nonzero(sizes == 1)
    ratio = (np.count_nonzero(sizes == 2) + 1.0) / (singles + 2.0)
    by_chance = singles * min(ratio, 1.0) ** (sizes - 1.0)
    return [
        block
        for block, size, chance in zip(blocks, sizes, by_chance, strict=True)
        if size > 1 and chance < _BY_CHANCE
    ]


def stretches(marks: np.ndarray) -> list[tuple[int, int]]:
    """Begin and end of each stretch of marked samples."""
    edges = np.diff(marks.astype(int), prepend=0, append=0)
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [(int(a), int(b)) for a, b in zip(begins, ends, strict=True)]

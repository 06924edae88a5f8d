"""How far two runs have the same noise, though no row of them is the same."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from brace_drake.recording_faults.statistics import (
    local_error,
    robust_deviation,
)

# Of what is left of noise by `local_error` neighbours are of opposite sign,
# their correlation is -0.8, -0.5 where noise was averaged over two samples; of
# what a smooth motion leaves they are alike.
_WHITE = -0.25
# What is farther off is a jolt that both runs may have, no noise.
_JOLT = 3.0
# Of the shorter run's samples two runs overlap by at least so many.
_OVERLAP = 0.5
# A hum is alike at many delays, a copy at one and those beside it.
_BESIDE = 4
# Pieces of the overlap. A jolt is alike in a few, noise in all.
_PIECES = 12


class SharedNoise(NamedTuple):
    """The likeness of two runs' noise where one is moved along the other.

    Attributes:
        correlation: Of the whole overlap, at the best delay; -1 to 1.
        typical: The median over pieces of the overlap.
        elsewhere: The largest size of the correlation at any other delay.
        delay: By which the second run is moved, samples.
    """

    correlation: float
    typical: float
    elsewhere: float
    delay: int


def noise_of(values: np.ndarray) -> np.ndarray | None:
    """What of a reading no smooth motion explains, jolts cut off (N,); None
    where that is no noise.
    """
    error = local_error(np.asarray(values, dtype=float))
    most = _JOLT * (robust_deviation(error) or float(np.std(error)))
    noise = np.clip(error, -most, most)
    is_noise = noise[1:] @ noise[:-1] < _WHITE * (noise @ noise)
    return noise if is_noise else None


def compare_noise(a: np.ndarray, b: np.ndarray) -> SharedNoise | None:
    """The likeness of two runs' noise; None where they do not overlap.

    Independent noise of N samples is alike by 4 / sqrt(N) at the best of all
    delays; noise that was taken over, with as much of its own, by 0.7.

    Args:
        a, b: As of `noise_of`, (N,) and (M,).
    """
    delays, products = _products(a, b)
    begin, end = np.maximum(0, delays), np.minimum(len(a), delays + len(b))
    size = np.sqrt(
        _energy(a, begin, end) * _energy(b, begin - delays, end - delays)
    )
    least = _OVERLAP * min(len(a), len(b))
    known = (end - begin >= least) & (size > 0.0)
    if not known.any():
        return None
    delays, found = delays[known], products[known] / size[known]
    best = int(np.argmax(np.abs(found)))
    delay = int(delays[best])
    others = np.abs(found[np.abs(delays - delay) > _BESIDE])
    pieces = _pieces(a, b, delay)
    return SharedNoise(
        float(found[best]),
        float(np.median(pieces)) if len(pieces) else 0.0,
        float(others.max()) if len(others) else 0.0,
        delay,
    )


def _products(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Delays of b, and the sums of products of the samples that then meet."""
    length = 1 << (len(a) + len(b) - 2).bit_length()
    spectrum = np.fft.rfft(a, length) * np.conj(np.fft.rfft(b, length))
    sums = np.fft.irfft(spectrum, length)
    delays = np.arange(1 - len(b), len(a))
    return delays, sums[delays]


def _energy(x: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    sums = np.concatenate([[0.0], np.cumsum(x * x)])
    return sums[end] - sums[begin]


def _pieces(a: np.ndarray, b: np.ndarray, delay: int) -> np.ndarray:
    """Correlations of pieces of the overlap that have noise in both runs."""
    begin, end = max(0, delay), min(len(a), delay + len(b))
    mine, other = a[begin:end], b[begin - delay : end - delay]
    pairs = zip(
        np.array_split(mine, _PIECES),
        np.array_split(other, _PIECES),
        strict=True,
    )
    parts = [(x @ y, np.sqrt((x @ x) * (y @ y))) for x, y in pairs]
    return np.array([product / size for product, size in parts if size > 0.0])

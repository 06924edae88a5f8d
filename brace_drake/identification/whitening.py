"""Whitened residuals: series in which noise has variance 1 at any frequency.

A residual (N, C) is whitened in frequency by the weights of its noise floor,
up to the highest one that counts. `PreparedRun.weigh` lays the transform out as
one vector, real parts first; here are the ways back, to frequency and to time.
"""

from __future__ import annotations

import itertools

import numpy as np

from brace_drake.core.block_bootstrap import pieces_of
from brace_drake.identification.evaluation import Evaluator, PreparedRun

Band = tuple[float, float]


def in_frequency(prepared: PreparedRun, weighted: np.ndarray) -> np.ndarray:
    """A weighted residual as transform: the inverse of its layout.

    Args:
        prepared: The run.
        weighted: From its `weigh` (M,), or columns of such (M, n).

    Returns:
        (B, C) for B bins and C used channels, or (B, C, n).
    """
    bins, channels = len(prepared.weights), int(prepared.used.sum())
    out = np.zeros((bins, channels, *weighted.shape[1:]), dtype=complex)
    out.real = weighted[: bins * channels].reshape(out.shape)
    out.imag[1:] = weighted[bins * channels :].reshape(out[1:].shape)
    return out


def in_time(prepared: PreparedRun, weighted: np.ndarray) -> np.ndarray:
    """A weighted residual as a series of unit variance for pure noise.

    The transform is orthonormal: the sum of squares stays the same, and each
    value belongs to a time.

    Args:
        prepared: The run.
        weighted: From its `weigh` (M,).

    Returns:
        (2 B - 1, C) for B bins and C used channels, evenly over the run.
    """
    transform = in_frequency(prepared, weighted)
    transform[1:] /= np.sqrt(2.0)
    samples = 2 * len(transform) - 1
    return np.fft.irfft(transform, samples, axis=0, norm="ortho")


def in_pieces(evaluator: Evaluator, weighted: np.ndarray) -> list[np.ndarray]:
    """Weighted residuals of all runs in time, piece by piece (n, C), with 0 in
    channels that a run has not.
    """
    found = []
    edges = itertools.pairwise([0, *evaluator.ends])
    for run, (begin, end) in zip(evaluator.prepared, edges, strict=True):
        series = in_time(run, weighted[begin:end])
        whole = np.zeros((len(series), len(run.used)))
        whole[:, run.used] = series
        found += pieces_of(run.run, whole)
    return found


def band_in_frequency(
    prepared: PreparedRun, residual: np.ndarray, band: Band, rate: float
) -> tuple[np.ndarray, np.ndarray]:
    """One band of a residual, whitened.

    Args:
        prepared: The run.
        residual: (N, C).
        band: Limits, Hz.
        rate: Of the samples, Hz.

    Returns:
        The transform (N // 2 + 1, C), 0 outside of the band, and how often
        each bin is in it (N // 2 + 1,): 2, or 1 where it is real; 0 outside.
    """
    samples, bins = len(residual), len(prepared.weights)
    frequency = np.fft.rfftfreq(samples, 1.0 / rate)
    inside = (frequency >= band[0]) & (frequency < band[1])
    inside[bins:] = False
    transform = np.fft.rfft(residual, axis=0)
    transform[:bins] *= prepared.weights
    transform[~inside] = 0.0
    sides = np.full(len(frequency), 2.0)
    sides[0] = 1.0
    if samples % 2 == 0:
        sides[-1] = 1.0
    return transform, sides * inside


def band_in_time(
    prepared: PreparedRun, residual: np.ndarray, band: Band, rate: float
) -> tuple[np.ndarray, float]:
    """One band of a residual as a whitened series (N, C), and the mean square
    that noise alone has in it; see `band_in_frequency`.
    """
    samples = len(residual)
    transform, sides = band_in_frequency(prepared, residual, band, rate)
    # Weights count both sides of the spectrum, the transform back does too.
    scale = np.sqrt(np.maximum(sides, 1.0))[:, None]
    series = np.fft.irfft(transform / scale, samples, axis=0, norm="ortho")
    return series, float(sides.sum() / samples)

"""Whitened residuals: series in which noise has variance 1 at any frequency.

A residual (N, C) is whitened in frequency by the weights of its noise floor,
up to the highest one that counts. `PreparedRun.weigh` lays the transform out as
one vector; here is the way back to time.
"""

from __future__ import annotations

import itertools

import numpy as np

from brace_drake.core.block_bootstrap import pieces_of
from brace_drake.core.cosine_transform import (
    frequencies_of,
    to_frequency,
    to_time,
)
from brace_drake.identification.evaluation import Evaluator, PreparedRun

Band = tuple[float, float]


def in_time(prepared: PreparedRun, weighted: np.ndarray) -> np.ndarray:
    """A weighted residual as a series of unit variance for pure noise.

    The transform is orthonormal: the sum of squares stays the same, and each
    value belongs to a time.

    Args:
        prepared: The run.
        weighted: From its `weigh` (M,).

    Returns:
        (B, C) for B frequencies and C used channels, evenly over the run.
    """
    return to_time(weighted.reshape(len(prepared.weights), -1))


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
        The transform (N, C), 0 outside of the band, and which frequencies are
        in it (N,).
    """
    frequency = frequencies_of(len(residual), rate)
    inside = (frequency >= band[0]) & (frequency < band[1])
    inside[len(prepared.weights) :] = False
    transform = to_frequency(residual)
    transform[: len(prepared.weights)] *= prepared.weights
    transform[~inside] = 0.0
    return transform, inside


def band_in_time(
    prepared: PreparedRun, residual: np.ndarray, band: Band, rate: float
) -> tuple[np.ndarray, float]:
    """One band of a residual as a whitened series (N, C), and the mean square
    that noise alone has in it; see `band_in_frequency`.
    """
    transform, inside = band_in_frequency(prepared, residual, band, rate)
    return to_time(transform), float(inside.mean())

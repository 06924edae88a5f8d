"""Weighted residuals back in time, where their noise is white."""

from __future__ import annotations

import numpy as np

from brace_drake.identification.evaluation import PreparedRun


def in_time(prepared: PreparedRun, weighted: np.ndarray) -> np.ndarray:
    """A weighted residual as a series of unit variance for pure noise.

    The inverse of `PreparedRun.weigh` followed by an orthonormal transform:
    the sum of squares stays the same, and each value belongs to a time.

    Args:
        prepared: The run.
        weighted: From its `weigh` (M,).

    Returns:
        (2 B - 1, C) for B bins and C used channels, evenly over the run.
    """
    bins, channels = len(prepared.weights), int(prepared.used.sum())
    real = weighted[: bins * channels].reshape(bins, channels)
    transform = real.astype(complex)
    transform[1:] += 1j * weighted[bins * channels :].reshape(-1, channels)
    transform[1:] /= np.sqrt(2.0)
    return np.fft.irfft(transform, 2 * bins - 1, axis=0, norm="ortho")

"""How a ring has moved, from the leg lengths that were recorded."""

from __future__ import annotations

import numpy as np

from brace_drake.laws.loop import replay
from brace_drake.laws.numbers import BraceNumbers


def ring_poses(
    numbers: BraceNumbers, lengths: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Task coordinates (N, 6n), Jacobians (N, 6n, 6n) of measured leg lengths.

    Args:
        numbers: Whose nominal anchors and rest pose count.
        lengths: Of each sample (N, 6n), m.
    """
    size = lengths.shape[1]
    X = np.empty((len(lengths), size))
    jacobians = np.empty((len(lengths), size, size))
    replay.calc_poses(np.ascontiguousarray(lengths), numbers, X, jacobians)
    return X, jacobians


def low_pass(signal: np.ndarray, cutoff_hz: float, rate: float) -> np.ndarray:
    """Zero-phase low pass along time by a smooth cut of the spectrum."""
    extended = np.concatenate([signal, signal[::-1]])
    frequency = np.fft.rfftfreq(len(extended), 1.0 / rate)
    taper = 1.0 / (1.0 + (frequency / cutoff_hz) ** 8)
    shape = (-1,) + (1,) * (signal.ndim - 1)
    spectrum = np.fft.rfft(extended, axis=0) * taper.reshape(shape)
    return np.fft.irfft(spectrum, len(extended), axis=0)[: len(signal)]

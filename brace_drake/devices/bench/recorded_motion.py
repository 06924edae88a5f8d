"""How a ring has moved, from the leg lengths that were recorded."""

from __future__ import annotations

import numpy as np

from brace_drake.laws.loop import bench_replay
from brace_drake.scenario.bench_numbers import BenchNumbers


def ring_poses(
    numbers: BenchNumbers, lengths: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Poses (N, 6) and leg Jacobians (N, 6, 6) of measured leg lengths.

    Args:
        numbers: Whose nominal anchors and rest pose count.
        lengths: Of each sample (N, 6), m.
    """
    n = numbers
    poses, jacobians = (
        np.empty((len(lengths), 6)),
        np.empty((len(lengths), 6, 6)),
    )
    bench_replay.calc_poses(
        np.ascontiguousarray(lengths), n.p_WB, n.p_RT, n.rest, poses, jacobians
    )
    return poses, jacobians


def low_pass(signal: np.ndarray, cutoff_hz: float, rate: float) -> np.ndarray:
    """Zero-phase low pass along time by a smooth cut of the spectrum."""
    extended = np.concatenate([signal, signal[::-1]])
    frequency = np.fft.rfftfreq(len(extended), 1.0 / rate)
    taper = 1.0 / (1.0 + (frequency / cutoff_hz) ** 8)
    shape = (-1,) + (1,) * (signal.ndim - 1)
    spectrum = np.fft.rfft(extended, axis=0) * taper.reshape(shape)
    return np.fft.irfft(spectrum, len(extended), axis=0)[: len(signal)]

"""The noise floor: how far a recording is from a perfect twin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.cosine_transform import frequencies_of, to_frequency

# Bands in which the noise spectrum is taken as flat, Hz.
_EDGES = np.concatenate([[0.0], np.geomspace(0.15, 400.0, 34)])


@dataclass(frozen=True)
class NoiseFloor:
    """Noise of one kind of run, channel by channel.

    Attributes:
        rms: Root mean square of each channel (C,).
        edges: Limits of the bands (B + 1,), Hz.
        density: Mean square of `to_frequency` in each band (B, C): the power
            of a bin, |rfft|^2 / N.
    """

    rms: np.ndarray
    edges: np.ndarray
    density: np.ndarray

    def weights(
        self, samples: int, rate: float, highest: float = np.inf
    ) -> np.ndarray:
        """Factors that make `to_frequency` of noise of unit variance.

        Args:
            samples: N of the series.
            rate: Hz.
            highest: Frequency that counts, Hz.

        Returns:
            (B, C) of the B frequencies up to the highest, N without one; 0 for
            channels without noise.
        """
        frequency = frequencies_of(samples, rate)
        band = np.clip(
            np.searchsorted(self.edges, frequency, side="right") - 1,
            0,
            len(self.density) - 1,
        )
        with np.errstate(divide="ignore"):
            weights = 1.0 / np.sqrt(self.density[band])
        weights[~np.isfinite(weights)] = 0.0
        return weights[frequency <= highest]

    def scaled(self, variance_ratio: np.ndarray) -> NoiseFloor:
        """The floor with each channel's variance multiplied."""
        return NoiseFloor(
            self.rms * np.sqrt(variance_ratio),
            self.edges,
            self.density * variance_ratio,
        )


def estimate_floor(
    noise: np.ndarray, rate: float, quantum: np.ndarray
) -> NoiseFloor:
    """The floor from replicates of pure noise.

    Args:
        noise: (replicates, N, C).
        rate: Hz.
        quantum: Step in which each channel is written down (C,): rounding to
            it adds quantum^2 / 12.
    """
    _, samples, channels = noise.shape
    rounding = quantum**2 / 12.0
    frequency = frequencies_of(samples, rate)
    mean_power = np.mean(to_frequency(noise, axis=1) ** 2, axis=0)
    density = np.zeros((len(_EDGES) - 1, channels))
    filled = np.zeros(len(_EDGES) - 1, dtype=bool)
    for b in range(len(density)):
        inside = (frequency >= _EDGES[b]) & (frequency < _EDGES[b + 1])
        if inside.any():
            density[b] = mean_power[inside].mean(axis=0)
            filled[b] = True
    indices = np.arange(len(density))
    for c in range(channels):
        density[:, c] = np.interp(indices, indices[filled], density[filled, c])
    rms = np.sqrt(np.mean(noise**2, axis=(0, 1)) + rounding)
    return NoiseFloor(rms, _EDGES, density + rounding)


def is_on_grid(column: np.ndarray, step: float) -> bool:
    """Whether a column takes several values, all multiples of a step."""
    multiples = np.round(column / step)
    return bool(
        np.ptp(multiples) > 0
        and np.allclose(column / step, multiples, rtol=0.0, atol=1e-3)
    )


def written_quantum(recorded: np.ndarray, simulated: np.ndarray) -> np.ndarray:
    """Step to which each column was rounded when it was written (C,).

    The coarsest power of ten of which all recorded values are multiples; 0
    where there is none, or where simulated readings lie on the same grid and
    so have that rounding already.

    Args:
        recorded, simulated: (N, C).
    """
    quantum = np.zeros(recorded.shape[1])
    for c, column in enumerate(recorded.T):
        for exponent in range(0, -13, -1):
            step = 10.0**exponent
            if is_on_grid(column, step):
                if not is_on_grid(simulated[:, c], step):
                    quantum[c] = step
                break
    return quantum


def on_grid(values: np.ndarray, quantum: np.ndarray) -> np.ndarray:
    """Values rounded to the steps of their columns, where these are not 0."""
    step = np.where(quantum > 0.0, quantum, 1.0)
    return np.where(quantum > 0.0, np.round(values / step) * step, values)


def repeat_ratio(
    difference: np.ndarray, floor: NoiseFloor, rate: float
) -> np.ndarray:
    """Variance of a repeat against the floor, robust to lines and drifts.

    The median over pairs of neighbouring frequencies of half the difference's
    power against the floor, which for noise of the floor's size is 1 and which
    a motion that did not repeat, confined to a few of them, leaves alone.

    Returns:
        (C,), NaN where a channel has no floor.
    """
    weights = floor.weights(len(difference), rate)
    power = (to_frequency(difference) * weights)[1:] ** 2
    pairs = len(power) // 2
    # Two squares of noise of twice the variance: 4 log 2 is their median.
    power = power[: 2 * pairs].reshape(pairs, 2, -1).sum(axis=1)
    ratio = np.median(power, axis=0) / (4.0 * np.log(2.0))
    return np.where(weights[1] > 0.0, ratio, np.nan)

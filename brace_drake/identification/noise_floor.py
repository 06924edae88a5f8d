"""The noise floor: how far a recording is from a perfect twin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.cosine_transform import frequencies_of, to_frequency

# A step that is so many times an instrument's is another.
_COARSER = 1.5
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
        rounding: The part that writing readings down makes, which repeats
            share and do not show; None without.
    """

    rms: np.ndarray
    edges: np.ndarray
    density: np.ndarray
    rounding: NoiseFloor | None = None

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
        """The floor with each channel's variance multiplied, down to what
        rounding alone makes.
        """
        rms = self.rms * np.sqrt(variance_ratio)
        density = self.density * variance_ratio
        least = self.rounding
        if least is not None:
            rms = np.maximum(rms, np.minimum(self.rms, least.rms))
            density = np.maximum(
                density, np.minimum(self.density, least.density)
            )
        return NoiseFloor(rms, self.edges, density, least)


def estimate_floor(
    noise: np.ndarray, rate: float, rounding: np.ndarray | None = None
) -> NoiseFloor:
    """The floor from replicates of pure noise.

    Args:
        noise: (replicates, N, C).
        rate: Hz.
        rounding: What writing them down has added, of the same shape.
    """
    if rounding is None:
        rms = np.sqrt(np.mean(noise**2, axis=(0, 1)))
        return NoiseFloor(rms, _EDGES, _density_of(noise, rate))
    whole = estimate_floor(noise + rounding, rate)
    return replace(whole, rounding=estimate_floor(rounding, rate))


def _density_of(noise: np.ndarray, rate: float) -> np.ndarray:
    """Mean square of `to_frequency` in each band (B, C)."""
    _, samples, channels = noise.shape
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
    return density


def is_on_grid(column: np.ndarray, step: float) -> bool:
    """Whether a column takes several values, a step apart or several."""
    places = (column - column[0]) / step
    multiples = np.round(places)
    return bool(
        np.ptp(multiples) > 0
        and np.allclose(places, multiples, rtol=0.0, atol=1e-3)
    )


def written_quantum(recorded: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Step to which each column was rounded when it was written (C,).

    The least step between two of its values, where all lie on a grid of it; 0
    where they do not, or where the step is the instrument's.

    Args:
        recorded: (N, C).
        steps: Of the instruments, whose rounding is noise of theirs (C,).
    """
    quantum = np.zeros(recorded.shape[1])
    for c, column in enumerate(recorded.T):
        step, extent = quantum_of(column), float(np.ptp(column))
        if step > 0.0:
            # Floating point spoils a small difference, the range it does not.
            step = extent / round(extent / step)
            is_new = step > _COARSER * steps[c]
            quantum[c] = step if is_new and is_on_grid(column, step) else 0.0
    return quantum


def quantum_of(values: np.ndarray) -> float:
    """Least step between different values; 0 of a constant."""
    steps = np.diff(np.unique(values))
    # What floating point makes of equal values is no step.
    steps = steps[steps > 1e-9 * max(1e-9, float(np.abs(values).max()))]
    return float(steps.min()) if len(steps) else 0.0


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

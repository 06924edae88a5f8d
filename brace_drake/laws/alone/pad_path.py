"""From displacement readings to the path of a pad: smoothing and slopes."""

from __future__ import annotations

import numpy as np
from scipy.fft import dct, idct

# A frequency counts as motion where its power is this many times the noise's.
_ABOVE_NOISE = 4.0
# Values of the spectrum that are averaged before that comparison.
_AVERAGED = 9
_ORDER = 8
# Samples from which the slope of an end is first taken, and at least.
_FIRST_END, _LEAST_END = 9, 5
# Changes of slope below this many standard deviations are noise.
_SIGNIFICANT = 4.0
# Rounding of a slope, relative to the largest.
_ROUNDING = 1e-6


def filter_cosines(signal: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Filters (N,) without phase: `gain` (N,) on its cosine transform.

    The transform takes the signal as mirrored at both ends, so that a record
    that ends elsewhere than it began is no step. A parabola with the slopes of
    the ends is taken off before, so that one that is cut off in the middle of
    a motion has no corner there.
    """
    if np.all(gain == 1.0):
        return signal.copy()
    ends = _sloped_as_ends(signal, int(2.0 * reach_of(gain)))
    return ends + idct(gain * dct(signal - ends, norm="ortho"), norm="ortho")


def reach_of(gain: np.ndarray) -> float:
    """Samples over which a filter takes a mean; 0 without any."""
    if np.all(gain == 1.0):
        return 0.0
    return 0.5 * len(gain) / max(1, np.count_nonzero(gain > 0.5))


def _sloped_as_ends(signal: np.ndarray, samples: int) -> np.ndarray:
    """The parabola with the slopes that a signal (N,) has at its ends (N,).

    Args:
        signal: N >= 2.
        samples: At each end, through which a parabola gives the slope.
    """
    count = len(signal)
    if count < _LEAST_END:
        return np.zeros(count)
    samples = min(count, max(_LEAST_END, samples))
    n = np.arange(samples)
    first = np.polyfit(n, signal[:samples], 2)[1]
    last = -np.polyfit(n, signal[::-1][:samples], 2)[1]
    s = np.arange(count, dtype=float)
    return first * s + 0.5 * (last - first) * s**2 / (count - 1)


def noise_gain(displacement: np.ndarray, sigma: float) -> np.ndarray:
    """The low pass that a displacement's own noise asks for (N,).

    Its cutoff is the highest frequency at which the displacement still stands
    above the white noise of its readings: beyond that the recording holds no
    motion, and differentiating it would feed noise to the damping. Readings
    without noise are left as they are.

    Args:
        displacement: (N,), m.
        sigma: Standard deviation of the noise of a reading, m.
    """
    samples = len(displacement)
    near = _cutoff(displacement, sigma, _FIRST_END)
    cutoff = _cutoff(displacement, sigma, samples // near)
    if cutoff + _AVERAGED >= samples:
        return np.ones(samples)
    return 1.0 / (1.0 + (np.arange(samples) / cutoff) ** _ORDER)


def _cutoff(displacement: np.ndarray, sigma: float, ends: int) -> int:
    """Values of the spectrum up to the last that stands above noise, 1 at
    least; `ends` as of `_sloped_as_ends`.
    """
    samples = len(displacement)
    flat = displacement - _sloped_as_ends(displacement, ends)
    power = dct(flat - flat.mean(), norm="ortho") ** 2
    box = np.ones(min(_AVERAGED, samples))
    counts = np.convolve(np.ones(samples), box, mode="same")
    power = np.convolve(power, box, mode="same") / counts
    above = np.flatnonzero(power > _ABOVE_NOISE * sigma**2)
    return int(above[-1]) + 1 if len(above) else 1


def path_slopes(
    time: np.ndarray, displacement: np.ndarray, sigma: float
) -> tuple[np.ndarray, np.ndarray]:
    """Rates of a path at its samples, and where they are in doubt.

    Akima's slopes: of the secants on both sides the one counts more whose own
    side is the straighter, which puts a corner between two samples where it
    is. What noise does to the weights is added to both. A corner on a sample
    then has the mean of both slopes, and its rate may be either.

    Args:
        time, displacement: (N,), s and m; N >= 2.
        sigma: Standard deviation of the noise of a reading, m.

    Returns:
        Rates (N,), m/s; jumps of the slope at corners on samples (N,), m/s,
        0 elsewhere.

    Source: Akima, J. ACM 17, 1970.
    """
    step = np.diff(time)
    secants = np.diff(displacement) / step
    s = _with_two_more(secants)
    change = np.abs(np.diff(s))
    noise = _SIGNIFICANT * np.sqrt(6.0) * sigma / np.median(step)
    noise += _ROUNDING * np.abs(secants).max() + 1e-30
    left, right = change[:-2], change[2:]
    before, after = s[1:-2], s[2:-1]
    weight = right + noise, left + noise
    rate = (weight[0] * before + weight[1] * after) / (weight[0] + weight[1])
    jump = after - before
    doubtful = (np.abs(jump) > 4.0 * noise) & (
        np.maximum(left, right) < np.maximum(noise, 0.05 * np.abs(jump))
    )
    return rate, np.where(doubtful, jump, 0.0)


def _with_two_more(secants: np.ndarray) -> np.ndarray:
    """Secants (M,) with two more on both sides, in a straight line (M + 4,)."""
    first = last = 0.0
    if len(secants) > 1:
        first, last = secants[1] - secants[0], secants[-1] - secants[-2]
    before = secants[0] - first * np.array([2.0, 1.0])
    after = secants[-1] + last * np.array([1.0, 2.0])
    return np.concatenate([before, secants, after])

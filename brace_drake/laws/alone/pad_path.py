"""From displacement readings to the path of a pad: smoothing and slopes."""

from __future__ import annotations

import numpy as np
from scipy.fft import dct, idct

# Power of the frequency with which the power of a motion falls at least.
_FALL = 6
# Samples from which the slope of an end is taken at least, and how many such
# numbers of samples are tried in an octave.
_LEAST_END, _ENDS_PER_OCTAVE = 5, 3
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
    """The Wiener filter of a displacement in white noise (N,).

    The motion stands above the noise up to a cutoff c, see `_cutoff`. From
    there its power falls with the sixth power of the frequency, as that of a
    motion whose acceleration leaps does: S = ln N sigma^2 (c / k)^6. The gain
    is S / (S + sigma^2), and what is not known of the filtered displacement has
    the power sigma^2 times the gain. Readings without noise are left as they
    are.

    Args:
        displacement: (N,), m.
        sigma: Standard deviation of the noise of a reading, m.
    """
    samples = len(displacement)
    cutoff = _cutoff(displacement, sigma)
    if cutoff >= samples:
        return np.ones(samples)
    from_cutoff = np.arange(samples) / cutoff
    return 1.0 / (1.0 + from_cutoff**_FALL / _price(samples))


def _price(samples: int) -> float:
    """Power over noise from which a frequency counts as motion.

    ln N, so that all of a band has to pay for its width (Schwarz, Ann. Stat. 6,
    1978): rounding is noise in single lines where a motion is periodic.
    """
    return float(np.log(max(3, samples)))


def _cutoff(displacement: np.ndarray, sigma: float) -> int:
    """Values of the spectrum up to which a displacement stands above noise.

    The one, 1 at least, of least sum of squares beyond it and price of those up
    to it. What is left beyond depends on the slopes of the ends, taken over as
    many samples as a filter of that cutoff takes its mean.
    """
    samples = len(displacement)
    price = _price(samples) * sigma**2
    number = max(1, round(np.log2(samples / _LEAST_END) * _ENDS_PER_OCTAVE))
    ratio = (samples / _LEAST_END) ** (1.0 / number)
    least, cutoff = np.inf, samples
    for n in range(number + 1):
        highest = samples / ratio**n
        ends = max(_LEAST_END, int(samples / highest))
        flat = displacement - _sloped_as_ends(displacement, ends)
        power = dct(flat - flat.mean(), norm="ortho") ** 2
        beyond = np.cumsum(power[::-1])[::-1] - power
        score = beyond + price * np.arange(1, samples + 1)
        low = int(highest / ratio) if n < number else 0
        place = low + int(np.argmin(score[low : int(highest)]))
        if score[place] < least:
            least, cutoff = score[place], place + 1
    return cutoff


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

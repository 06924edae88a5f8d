"""Since when a whitened series is more than noise, at a stated rate of alarms.

Of noise alone, over the last n samples of c channels of variance 1,

    E = sum z^2              is chi-square of n c degrees of freedom,
    M = n m' S^-1 m, m = mean z,   is Hotelling's T^2 of c degrees of freedom:

E shows what comes and goes, M what is small and lasts. S, the covariance of
sqrt(n) m, would be the identity if z were white. It is estimated from k windows
of noise, so that (k - c) / (c (k - 1)) T^2 has the F distribution of c and
k - c degrees of freedom (Anderson, An Introduction to Multivariate Statistical
Analysis, 2003, section 5.2). At each look both are held, over several lengths
of time, against the value that each exceeds with probability p. However
dependent the tests of different looks are, the expected number of false alarms
is at most the sum of their probabilities (Boole), so that

    p = rate x time between looks / number of tests at a look

keeps the rate. Noise is not known better than to its level: E and M have to be
beyond that as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2
from scipy.stats import f as f_distribution

# The instruments' noise is known to 5 %, its square to 10 %, as in a diagnosis.
LEVEL = 0.10
# Over so long is looked back, s, so often, s.
WINDOWS = (0.25, 1.0, 5.0)
LOOK = 0.1
# Within so long before an alarm its beginning is looked for, s.
_LOOK_BACK = 10.0


@dataclass(frozen=True)
class Thresholds:
    """Tests of a whitened series at a look.

    Attributes:
        samples: Of each window (w,).
        energy, mean: Values of E and M that each window may not exceed (w,).
        covariances: S of each window (w, c, c).
        every: Samples between looks.
    """

    samples: tuple[int, ...]
    energy: np.ndarray
    mean: np.ndarray
    covariances: np.ndarray
    every: int


def make_thresholds(
    noise: np.ndarray, rate: float, per_hour: float, level: float = LEVEL
) -> Thresholds:
    """Thresholds from a rate of false alarms.

    Args:
        noise: Whitened series of noise alone (replicates, N, c). Windows that
            are longer are left out; of each other one there must be more than
            c in all.
        rate: Of the samples, Hz.
        per_hour: False alarms in an hour, at most, in expectation.
        level: To which the square of the noise is known.
    """
    channels = noise.shape[2]
    every = max(1, round(LOOK * rate))
    samples = tuple(
        n for n in (round(w * rate) for w in WINDOWS) if n <= noise.shape[1]
    )
    looks = 3600.0 * rate / every
    p = per_hour / looks / (2 * len(samples))
    energy = chi2.isf(p, channels * np.array(samples))
    means, covariances = [], []
    for n in samples:
        k = noise.shape[1] // n
        parts = noise[:, : k * n].reshape(-1, n, channels)
        sums = parts.sum(axis=1) / np.sqrt(n)
        covariances.append(sums.T @ sums / len(sums))
        free = len(sums) - channels
        part = f_distribution.isf(p, channels, free)
        means.append(channels * (len(sums) - 1) / free * part)
    return Thresholds(
        samples,
        (1.0 + level) * energy,
        (1.0 + level) * np.array(means),
        np.array(covariances),
        every,
    )


def calc_excess(series: np.ndarray, thresholds: Thresholds) -> float:
    """Largest of all tests at the end of a series, 1 at the threshold.

    Args:
        series: Whitened (N, c), the last sample last; windows that are longer
            than it are left out.
        thresholds: From `make_thresholds`.
    """
    worst = 0.0
    for n, energy, mean, covariance in zip(
        thresholds.samples,
        thresholds.energy,
        thresholds.mean,
        thresholds.covariances,
        strict=True,
    ):
        if n > len(series):
            continue
        last = series[-n:]
        m = last.sum(axis=0) / np.sqrt(n)
        own = float(m @ np.linalg.solve(covariance, m)) / mean
        worst = max(worst, float(np.sum(last * last)) / energy, own)
    return worst


def estimate_onset(series: np.ndarray, rate: float) -> int:
    """Where in a whitened series (N, c) what ends it has begun.

    The likeliest sample at which the mean square changed from 1 to another
    one, s, that lasts to the end: n c (s - 1 - ln s) / 2 is the gain of the log
    likelihood from n samples.

    Args:
        series: Up to an alarm; its last 10 s are looked at.
        rate: Hz.
    """
    first = max(0, len(series) - round(_LOOK_BACK * rate))
    squares = np.mean(series[first:] ** 2, axis=1)[::-1]
    number = np.arange(1, len(squares) + 1)
    s = np.maximum(np.cumsum(squares) / number, 1.0)
    gain = number * (s - 1.0 - np.log(s))
    return len(series) - 1 - int(np.argmax(gain))

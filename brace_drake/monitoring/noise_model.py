"""Noise of a closed loop as an autoregression, and differences whitened by it.

Noise of the readings comes back through the loop, so that it is neither white
nor independent from channel to channel. With

    r_t = sum_i A_i r_{t-l_i} + e_t,    cov e = L L'

the innovations z_t = L^-1 e_t of noise alone are independent in time and from
channel to channel, each of variance 1 (Luetkepohl, New Introduction to Multiple
Time Series Analysis, 2005, section 3.2). What else is in r shows in z as
filtered by the same polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# More of them whiten the noise of the bench's loop at 200 Hz little better.
LAGS = (1, 2, 3, 4, 8, 16)


@dataclass(frozen=True)
class NoiseModel:
    """An autoregression of c channels.

    Attributes:
        used: Channels that have noise, of all (C,).
        lags: l_i, samples, the longest last (p,).
        coefficients: A_i beside each other (c, p c).
        whitener: L^-1 (c, c).
    """

    used: np.ndarray
    lags: tuple[int, ...]
    coefficients: np.ndarray
    whitener: np.ndarray

    def whiten(
        self, series: np.ndarray, before: np.ndarray | None = None
    ) -> np.ndarray:
        """Innovations of unit variance (N, c) of a series (N, C).

        Args:
            series: Differences between machine and twin.
            before: The same of the samples before, the last one last (m, C);
                earlier ones are taken as 0.
        """
        longest, mine = self.lags[-1], series[:, self.used]
        past = np.zeros((longest, mine.shape[1]))
        if before is not None and len(before):
            last = before[-longest:, self.used]
            past[longest - len(last) :] = last
        given = _lagged(np.concatenate([past, mine]), self.lags)
        return (mine - given @ self.coefficients.T) @ self.whitener.T


def fit_noise_model(
    noise: np.ndarray, lags: tuple[int, ...] = LAGS
) -> NoiseModel:
    """The autoregression of recordings of noise alone, by least squares.

    Args:
        noise: (replicates, N, C).
        lags: l_i, ascending.
    """
    used = noise.std(axis=(0, 1)) > 0.0
    mine = noise[:, :, used]
    # Each channel in its own size: what is small is told as well.
    size = mine.std(axis=(0, 1))
    given = np.concatenate([_lagged(n / size, lags) for n in mine])
    found = np.concatenate([n[lags[-1] :] / size for n in mine])
    gram, cross = given.T @ given, given.T @ found
    slope = np.linalg.lstsq(gram, cross, rcond=None)[0].T
    rest = found - given @ slope.T
    covariance = rest.T @ rest / (len(rest) - slope.shape[1])
    whitener = np.linalg.inv(np.linalg.cholesky(covariance)) / size
    scaled = size[:, None] * slope / np.tile(size, len(lags))
    return NoiseModel(used, tuple(lags), scaled, whitener)


def _lagged(series: np.ndarray, lags: tuple[int, ...]) -> np.ndarray:
    """Samples before each one from the longest lag on (N - l_p, p c)."""
    first = lags[-1]
    rows = len(series) - first
    return np.concatenate(
        [series[first - k : first - k + rows] for k in lags], axis=1
    )

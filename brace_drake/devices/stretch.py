"""How far numbers known to a tolerance are stretched by what a residual shows.

Numbers that share an error, as the anchors along a leg do, each take a small
part of it: of every estimate it is asked how far its tolerance and the noise
let it move. What else there is in the residual counts as noise along the
numbers, as large as it shows along most of them. Of many numbers one is far off
by chance: the farthest of them is told as one number would be that is off so by
the same chance (Sidak, Rectangular confidence regions for the means of
multivariate normal distributions, J. Am. Stat. Assoc. 62, 1967).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import gammaincinv, log_ndtr, ndtri_exp

from brace_drake.devices.tolerances import LinearTolerances

# Of the square of a standard normal variable.
_MEDIAN = float(2.0 * gammaincinv(0.5, 0.5))
# Prior deviation of an estimate below which the data say nothing of a number.
_TOLD = 1e-3


def stretch_of(
    known: LinearTolerances, whitened: np.ndarray, least: float = 1.0
) -> float:
    """How far the farthest number is off, in standard deviations of one.

    An estimate with the posterior deviation s, in tolerances, has the prior
    deviation sqrt(1 - s^2): so far it moves where all is right. As many
    estimates move by themselves as the recording tells of numbers,
    sum_i lambda_i / (v + lambda_i), see `noise_along`.

    Args:
        known: The numbers and what they change.
        whitened: Residual after `LinearTolerances.whiten` (rows,).
        least: Variance of the noise along the numbers at least.
    """
    along = known.along(whitened)
    noise = max(least, noise_along(known, along))
    squares = known.principal[1] ** 2
    told = float(np.sum(squares / (noise + squares)))
    farthest = float(np.max(np.abs(_moved(known, along, noise))))
    return as_of_one(farthest, max(1.0, told))


def as_of_one(deviations: float, number: float) -> float:
    """Deviations at which one normal variable is by the chance that the
    farthest of some is at least at so many; 0 where that is certain.

    Args:
        deviations: Of the farthest, either way.
        number: Of independent ones.
    """
    each = np.log(2.0) + log_ndtr(-deviations)
    if each >= 0.0:
        return 0.0
    # ln(1 - (1 - p)^n), n p where p is next to nothing.
    none = number * np.log1p(-np.exp(each))
    chance = np.log(-np.expm1(none)) if none < 0.0 else each + np.log(number)
    return float(max(0.0, -ndtri_exp(min(0.0, chance) - np.log(2.0))))


def variance_over(excess: float, number: int) -> float:
    """Variance of noise and of squares above it, if all of these lay along so
    many numbers or parameters.
    """
    return 1.0 + max(0.0, excess) / number


def noise_along(known: LinearTolerances, along: np.ndarray) -> float:
    """Variance of noise and of what else there is along the numbers, at least
    1.

    Along its principal direction i a residual has the variance v + lambda_i,
    where lambda_i is that of the numbers. v is the one that fits the median of
    all directions, once what the farthest number changes is left out: it does
    not pass for noise.

    Args:
        known: As of `stretch_of`.
        along: See `LinearTolerances.along`.
    """
    ways, sizes, numbers = known.principal
    parts = ways.T @ along
    first = _median_noise(parts, sizes)
    farthest = np.argmax(np.abs(_moved(known, along, first)))
    out = sizes * numbers[:, farthest]
    out /= max(float(np.linalg.norm(out)), 1e-300)
    return _median_noise(parts - out * (out @ parts), sizes)


def _moved(
    known: LinearTolerances, along: np.ndarray, noise: float
) -> np.ndarray:
    """Estimates over their prior deviations (n,)."""
    free = np.sqrt(np.maximum(1.0 - known.errors(noise) ** 2, _TOLD**2))
    return known.estimate(along, noise) / free


def _median_noise(parts: np.ndarray, sizes: np.ndarray) -> float:
    def beyond(noise):
        return np.median(parts**2 / (noise + sizes**2)) - _MEDIAN

    if beyond(1.0) <= 0.0:
        return 1.0
    most = float(np.max(parts**2)) / _MEDIAN
    return float(brentq(beyond, 1.0, most + 1.0))

"""How far numbers known to a tolerance are stretched by what a residual shows.

Numbers that share an error, as the anchors along a leg do, each take a small
part of it: of every estimate it is asked how far its tolerance and the noise
let it move. What else there is in the residual counts as noise along the
numbers, as large as it shows along most of them.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2

from brace_drake.devices.tolerances import LinearTolerances

# Of the square of a standard normal variable.
_MEDIAN = float(chi2.median(1))
# Prior deviation of an estimate below which the data say nothing of a number.
_TOLD = 1e-3


def stretch_of(
    known: LinearTolerances, whitened: np.ndarray, least: float = 1.0
) -> float:
    """The most standard deviations that an estimate of a number has moved.

    An estimate with the posterior deviation s, in tolerances, has the prior
    deviation sqrt(1 - s^2): so far it moves where all is right.

    Args:
        known: The numbers and what they change.
        whitened: Residual after `LinearTolerances.whiten` (rows,).
        least: Variance of the noise along the numbers at least.
    """
    noise = max(least, noise_along(known, whitened))
    moved = _moved(known, whitened, noise)
    return float(np.max(np.abs(moved)))


def noise_along(known: LinearTolerances, whitened: np.ndarray) -> float:
    """Variance of noise and of what else there is along the numbers, at least
    1.

    Along its principal direction i a residual has the variance v + lambda_i,
    where lambda_i is that of the numbers. v is the one that fits the median of
    all directions, once what the farthest number changes is left out: it does
    not pass for noise.

    Args:
        known, whitened: As of `stretch_of`.
    """
    ways, sizes, numbers = np.linalg.svd(known.columns, full_matrices=False)
    along = ways.T @ (known.basis.T @ known.colour(whitened))
    first = _median_noise(along, sizes)
    farthest = np.argmax(np.abs(_moved(known, whitened, first)))
    out = sizes * numbers[:, farthest]
    out /= max(float(np.linalg.norm(out)), 1e-300)
    return _median_noise(along - out * (out @ along), sizes)


def _moved(
    known: LinearTolerances, whitened: np.ndarray, noise: float
) -> np.ndarray:
    """Estimates over their prior deviations (n,)."""
    free = np.sqrt(np.maximum(1.0 - known.errors(noise) ** 2, _TOLD**2))
    return known.estimate(whitened, noise) / free


def _median_noise(along: np.ndarray, sizes: np.ndarray) -> float:
    def beyond(noise):
        return np.median(along**2 / (noise + sizes**2)) - _MEDIAN

    if beyond(1.0) <= 0.0:
        return 1.0
    most = float(np.max(along**2)) / _MEDIAN
    return float(brentq(beyond, 1.0, most + 1.0))

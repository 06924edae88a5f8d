"""Many alike parameters as a draw from one normal law: its spread, and whether
they look like one.

Under the prior N(0, s^2) the posterior mean m has the covariance s^2 I - P, P
being the posterior's: whitened by that, m is a sample of the unit normal law,
in the directions that the recording tells more of than the prior (posterior
predictive check; Gelman et al., Bayesian Data Analysis, chapter 6).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy

from brace_drake.devices.stretch import variance_over
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    calc_triangle,
)
from brace_drake.identification.problem import CandidateProblem

if TYPE_CHECKING:
    from brace_drake.identification.fits import CandidateFit

# A direction is told of where its variance is below this part of the prior's.
_TOLD = 0.5
# Median of the square of a unit normal variable.
_MEDIAN = 0.4549
# Standard deviations beyond which a direction does not count for the spread.
_OUTLIER = 3.0
# Level of each test, at most.
_LEVEL = 1e-3


def whiten(
    mean: np.ndarray, posterior: np.ndarray, spread: float
) -> np.ndarray:
    """Posterior mean by directions that are told of, whitened (k,).

    Args:
        mean: Of the alike parameters (n,).
        posterior: Their covariance (n, n).
        spread: Standard deviation of the prior s.
    """
    left, directions = np.linalg.eigh(posterior / spread**2)
    told = left < _TOLD
    projected = directions.T @ mean
    return projected[told] / (spread * np.sqrt(1.0 - left[told]))


def refit_spread(
    mean: np.ndarray, posterior: np.ndarray, spread: float
) -> float:
    """The spread that the directions themselves show.

    Their root mean square, outliers left out: where the twin is not exact, or
    the effect is another, a few directions that the recording tells little of
    go far, and would draw the spread after them.

    Args:
        mean, posterior, spread: See `whiten`.
    """
    squares = whiten(mean, posterior, spread) ** 2
    if len(squares) == 0:
        # Nothing is told: the prior alone, from which nothing is learnt.
        return spread
    typical = np.median(squares) / _MEDIAN
    if typical == 0.0:
        return spread
    kept = squares[squares <= _OUTLIER**2 * typical]
    return spread * float(np.sqrt(np.mean(kept)))


def looks_scattered(fit: CandidateFit) -> bool:
    """Whether a fit's alike parameters may be a draw from one normal law.

    With dozens of parameters an effect can imitate many others; but then a
    few directions among them carry all, and the rest is nearly nothing. Two
    tests: that of Kolmogorov and Smirnov, and, for outliers, the mean square
    held against an F law of as many directions. As the spread is found from
    the same directions, both refuse a true draw less often than their level.
    True where no effect has such parameters.
    """
    places = _places(fit)
    if len(places) == 0:
        return True
    jacobian = fit.solution.jacobian
    rows = len(jacobian) - fit.num_prior
    # What the twin leaves beyond noise makes its parameters less sure.
    left = variance_over(fit.excess, len(places))
    told, prior = jacobian[:rows], jacobian[rows:]
    precision = told.T @ told / left + prior.T @ prior
    posterior = np.linalg.pinv(precision, hermitian=True)
    sample = whiten(
        fit.solution.z[places],
        posterior[np.ix_(places, places)],
        fit.spread / fit.scales[places[0]],
    )
    if len(sample) == 0:
        return True
    stats, size = scipy.stats, len(sample)
    shape = stats.kstest(np.abs(sample), stats.halfnorm.cdf).pvalue
    outliers = stats.f.sf(np.mean(sample**2), size, size)
    return bool(2.0 * min(shape, outliers) > _LEVEL)


def _places(fit: CandidateFit) -> np.ndarray:
    """Places in z of parameters with a common spread."""
    at = len(fit.subject)
    for effect in fit.effects:
        runs = fit.num_runs * len(effect.run_parameters)
        count = int(effect.is_continuous.sum()) + runs
        if effect.spread is not None:
            return np.arange(at, at + count)
        at += count
    return np.zeros(0, dtype=int)


def with_prior(
    problem: CandidateProblem, solution: LeastSquaresSolution
) -> LeastSquaresSolution:
    """A solution with the rows of the prior as it is now."""
    rows = len(solution.residual) - problem.num_prior
    residual = solution.residual.copy()
    residual[rows:] = problem.prior_rows(solution.z)
    jacobian = solution.jacobian.copy()
    jacobian[rows:] = problem.prior_jacobian()
    return replace(solution, residual=residual, jacobian=jacobian)


def beside_noise(problem: CandidateProblem, fit: CandidateFit) -> CandidateFit:
    """A fit with the prior of alike parameters as beside noise alone."""
    if not problem.has_spread:
        return fit
    problem.weigh_alike()
    return replace(fit, solution=with_prior(problem, fit.solution))


def shown_spread(
    problem: CandidateProblem, solution: LeastSquaresSolution
) -> float:
    """Spread that the alike parameters show, scaled, see `scatter`."""
    triangle = calc_triangle([solution.jacobian])
    inverse = np.linalg.pinv(triangle)
    alike = problem.alike
    rows = inverse[alike]
    posterior = problem.left * rows @ rows.T
    return refit_spread(solution.z[alike], posterior, problem.spread)

"""Stated probabilities against how often the answers were right."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, logit

# Standard deviations of the prior of the offset, and of the slope about 1:
# with few cases the statement stays as it is.
_OFFSET, _SLOPE = 1.0, 0.5
_SUREST = 1e-3


@dataclass(frozen=True)
class Calibration:
    """Log-odds of being right: offset + slope * log-odds stated.

    Attributes:
        offset, slope: Most probable values.
        covariance: Of the two (2, 2), by Laplace's approximation.
        count: Answers that it was fitted to.
    """

    offset: float
    slope: float
    covariance: np.ndarray
    count: int

    def apply(self, stated: np.ndarray) -> np.ndarray:
        """Calibrated probabilities of stated ones."""
        return expit(self.offset + self.slope * log_odds(stated))


def fit_calibration(stated: np.ndarray, right: np.ndarray) -> Calibration:
    """Fits the log-odds of being right to those stated.

    Platt, "Probabilistic outputs for support vector machines", in Advances in
    Large Margin Classifiers, 1999; with a prior at what was stated.

    Args:
        stated: Probabilities (n,).
        right: Whether the answers were right (n,).
    """
    x, y = log_odds(stated), np.asarray(right, dtype=float)
    design = np.column_stack([np.ones_like(x), x])
    middle, precision = np.array([0.0, 1.0]), np.array([_OFFSET, _SLOPE]) ** -2

    def cost(theta):
        eta = design @ theta
        away = theta - middle
        return np.sum(np.logaddexp(0.0, eta) - y * eta) + 0.5 * np.sum(
            precision * away**2
        )

    def slope(theta):
        error = expit(design @ theta) - y
        return design.T @ error + precision * (theta - middle)

    best = minimize(cost, middle, jac=slope, method="BFGS").x
    p = expit(design @ best)
    curvature = (design.T * (p * (1.0 - p))) @ design + np.diag(precision)
    return Calibration(
        float(best[0]), float(best[1]), np.linalg.inv(curvature), len(x)
    )


def log_odds(probability: np.ndarray) -> np.ndarray:
    """Logarithm of p / (1 - p), p held off 0 and 1."""
    return logit(np.clip(probability, _SUREST, 1.0 - _SUREST))

"""Fits what the stated probabilities of withheld answers are worth.

    python tools/calibrate_probability.py SCORE.json [SCORE.json ...]
    python tools/calibrate_probability.py SCORE.json --check OTHER.json

Prints offset and slope of the log-odds of being right over those stated, with
standard errors, and log and Brier scores before and after: on the same cases,
and on cases that took no part.

`ODDS` in `brace_drake/selection/thresholds.py` weighs differences of scores in
the log-odds: times the slope that is printed it replaces itself. An offset has
no place there; one that is far from 0 says that the scores are not to be
trusted as they are.
"""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, logit

from brace_drake.withheld.score import SUREST, proper_scores

# Standard deviations of the prior of the offset, and of the slope about 1:
# with few cases the statement stays as it is.
_OFFSET, _SLOPE = 1.0, 0.5


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
    return logit(np.clip(probability, SUREST, 1.0 - SUREST))


def read(paths: list[Path]) -> tuple[np.ndarray, np.ndarray]:
    """Stated probabilities and whether the answers were right."""
    rows = [r for p in paths for r in json.loads(p.read_text())["each"]]
    told = [r for r in rows if r["probability"] is not None]
    return (
        np.array([r["probability"] for r in told], dtype=float),
        np.array([r["right"] for r in told], dtype=bool),
    )


def say(what: str, p: np.ndarray, right: np.ndarray) -> None:
    """Mean probability and scores of a set."""
    log, brier = proper_scores(p, right)
    print(
        f"{what:22} {len(p):3d} answers, told {p.mean():.3f},"
        f" right {right.mean():.3f}, log score {log:.3f}, Brier {brier:.3f}"
    )


def main() -> None:
    """Reads scores, fits, prints."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scores", nargs="+", type=Path, metavar="SCORE.json")
    parser.add_argument("--check", nargs="*", type=Path, default=[])
    args = parser.parse_args()
    told, right = read(args.scores)
    found = fit_calibration(told, right)
    errors = np.sqrt(np.diag(found.covariance))
    print(f"offset {found.offset:+.3f} (standard error {errors[0]:.3f})")
    print(f"slope  {found.slope:+.3f} (standard error {errors[1]:.3f})")
    say("as stated", told, right)
    say("calibrated", found.apply(told), right)
    if args.check:
        told, right = read(args.check)
        say("others, as stated", told, right)
        say("others, calibrated", found.apply(told), right)


if __name__ == "__main__":
    main()

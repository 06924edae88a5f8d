"""Is a change more than its uncertainty? Tests of estimates over time.

Each estimate x_i at time t_i comes with a standard error s_i. Two models of
what else is in it:

- stated: x_i = model(t_i) + s_i e_i, nothing else. Its tests say whether the
  estimates differ by more than their intervals.
- scattered: x_i = model(t_i) + sqrt(s_i^2 + tau^2) e_i, where tau is a scatter
  between sessions (a cable laid otherwise, a torso put down anew) that is
  estimated from the same few estimates, by the method of moments (DerSimonian
  and Laird). Its tests have the standard errors of Knapp and Hartung, never
  smaller ones, and Student's t with n - p degrees of freedom, so that few
  sessions give wide intervals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize, special

# Sessions from which a scatter can be told from a change at all.
LEAST_FOR_SCATTER = 4
_LEVEL = 0.05  # of intervals


@dataclass(frozen=True)
class Coefficient:
    """The last coefficient of a linear model.

    Attributes:
        value, error: Estimate and standard error.
        lower95, upper95: Its interval.
        p: Probability of one as far from 0 without a change; two-sided.
    """

    value: float
    error: float
    lower95: float
    upper95: float
    p: float


@dataclass(frozen=True)
class Fit:
    """A linear model of estimates, under both models of their errors.

    Attributes:
        chi2: Squared residuals over the stated errors.
        freedom: Degrees of freedom, n - p.
        stated: The coefficient where the stated errors are all there is.
        scatter: Standard deviation tau between sessions.
        scattered: The coefficient beside that scatter; None without freedom.
    """

    chi2: float
    freedom: int
    stated: Coefficient
    scatter: float
    scattered: Coefficient | None


def fit_linear(design: np.ndarray, x: np.ndarray, s: np.ndarray) -> Fit:
    """Fits x (n,) with errors s (n,) by the columns of a design (n, p)."""
    weight = 1.0 / s**2
    n, p = design.shape
    normal = np.linalg.inv(design.T @ (weight[:, None] * design))
    beta = normal @ (design.T @ (weight * x))
    chi2 = float(weight @ (x - design @ beta) ** 2)
    stated = _coefficient(beta[-1], math.sqrt(normal[-1, -1]), math.inf)
    if n == p:
        return Fit(chi2, 0, stated, 0.0, None)
    # Moments: what chi2 has beyond its expectation.
    trace = float(weight.sum()) - float(
        np.trace(normal @ (design.T @ ((weight**2)[:, None] * design)))
    )
    square = max(0.0, (chi2 - (n - p)) / trace)
    wide = 1.0 / (s**2 + square)
    normal = np.linalg.inv(design.T @ (wide[:, None] * design))
    beta = normal @ (design.T @ (wide * x))
    rest = float(wide @ (x - design @ beta) ** 2) / (n - p)
    error = math.sqrt(normal[-1, -1] * max(1.0, rest))
    scattered = _coefficient(beta[-1], error, n - p)
    return Fit(chi2, n - p, stated, math.sqrt(square), scattered)


def _coefficient(value: float, error: float, freedom: float) -> Coefficient:
    """Its interval and probability; infinite freedom is the normal law."""
    value = float(value)
    half = error * _quantile(1.0 - _LEVEL / 2.0, freedom)
    at = -abs(value) / error
    is_normal = math.isinf(freedom)
    tail = special.ndtr(at) if is_normal else special.stdtr(freedom, at)
    p = min(1.0, 2.0 * float(tail))
    return Coefficient(value, error, value - half, value + half, p)


def _quantile(p: float, freedom: float) -> float:
    """Of Student's law; of the normal one where the freedom is infinite."""
    if math.isinf(freedom):
        return float(special.ndtri(p))
    return float(special.stdtrit(freedom, p))


def fit_mean(x: np.ndarray, s: np.ndarray) -> Fit:
    """The weighted mean of estimates."""
    return fit_linear(np.ones((len(x), 1)), x, s)


def constancy(mean: Fit) -> tuple[float, float]:
    """Probability of so large a chi-square of constant estimates, and the
    Birge ratio, by which stated errors would have to be wider.

    Both need two estimates; 1 and 1 of a single one.
    """
    if mean.freedom == 0:
        return 1.0, 1.0
    p = float(special.chdtrc(mean.freedom, mean.chi2))
    return p, math.sqrt(mean.chi2 / mean.freedom)


def scatter_interval(x: np.ndarray, s: np.ndarray) -> tuple[float, float]:
    """95 % interval of the scatter between sessions, by the profile of the
    generalised chi-square; the upper end is infinite where nothing bounds it.
    """
    freedom = len(x) - 1
    low, high = special.chdtri(freedom, [_LEVEL / 2.0, 1.0 - _LEVEL / 2.0])

    def left(tau, target):
        wide = 1.0 / (s**2 + tau**2)
        mean = wide @ x / wide.sum()
        return float(wide @ (x - mean) ** 2 - target)

    def where(target):
        if left(0.0, target) <= 0.0:
            return 0.0
        far = float(np.ptp(x) + s.max())
        for _ in range(60):
            if left(far, target) < 0.0:
                return float(optimize.brentq(left, 0.0, far, args=(target,)))
            far *= 2.0
        return math.inf

    return where(low), where(high)


def fit_line(t: np.ndarray, x: np.ndarray, s: np.ndarray) -> Fit | None:
    """A weighted line; its coefficient is the slope, per unit of t.

    None where there are fewer than two times.
    """
    if len(x) < 2 or np.ptp(t) == 0.0:
        return None
    # Times about their mean, so that the normal equations stay well behaved.
    shift = (t - t.mean()) / np.ptp(t)
    found = fit_linear(np.column_stack([np.ones(len(t)), shift]), x, s)
    return _per_unit(found, float(np.ptp(t)))


def _per_unit(fit: Fit, span: float) -> Fit:
    def scaled(c: Coefficient) -> Coefficient:
        ends = c.value / span, c.error / span, c.lower95 / span
        return Coefficient(*ends, c.upper95 / span, c.p)

    other = fit.scattered and scaled(fit.scattered)
    return Fit(fit.chi2, fit.freedom, scaled(fit.stated), fit.scatter, other)


@dataclass(frozen=True)
class Step:
    """A change of the mean between two successive sessions.

    Attributes:
        after: Sessions before it.
        fit: Its coefficient is the change.
        p: Of the largest step anywhere, Bonferroni over where it may be.
        p_scattered: The same beside a scatter; 1 where none can be told.
    """

    after: int
    fit: Fit
    p: float
    p_scattered: float


def find_steps(x: np.ndarray, s: np.ndarray) -> tuple[Step, Step] | None:
    """The most significant step by the stated errors, and beside a scatter.

    Estimates are in the order of time. None of fewer than two.
    """
    n = len(x)
    if n < 2:
        return None
    fits = {
        k: fit_linear(np.column_stack([np.ones(n), np.arange(n) >= k]), x, s)
        for k in range(1, n)
    }
    stated = {k: fit.stated.p for k, fit in fits.items()}
    beside = {
        k: fit.scattered.p if fit.scattered else 1.0 for k, fit in fits.items()
    }

    def step(k: int) -> Step:
        found = [min(1.0, (n - 1) * each[k]) for each in (stated, beside)]
        return Step(k, fits[k], *found)

    # Of equally improbable ones that which leaves least.
    return (
        step(min(fits, key=lambda k: (stated[k], fits[k].chi2))),
        step(min(fits, key=lambda k: (beside[k], fits[k].chi2))),
    )


def detectable(coefficient: Coefficient, freedom: float, level: float) -> float:
    """Size of a coefficient that a two-sided test at `level` finds with 80 %
    probability; the normal law where the freedom is infinite.
    """
    power = float(special.ndtri(0.8))
    return coefficient.error * (_quantile(1.0 - level / 2.0, freedom) + power)


def holm(p: list[float]) -> list[float]:
    """Probabilities corrected for their number, Holm's step-down."""
    order = sorted(range(len(p)), key=lambda i: p[i])
    found, largest = [1.0] * len(p), 0.0
    for rank, i in enumerate(order):
        largest = max(largest, min(1.0, (len(p) - rank) * p[i]))
        found[i] = largest
    return found

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


def fit_linear(z: np.ndarray | None, x: np.ndarray, s: np.ndarray) -> Fit:
    """Fits x (n,) with errors s (n,) by a constant, and by z (n,) where it is
    given.

    Sums are of squares about weighted means, and nothing is subtracted of
    weights: errors may be of any two sizes.
    """
    n, p = len(x), 1 if z is None else 2
    weight = 1.0 / s**2
    value, error, chi2 = _weighted(z, x, weight)
    stated = _coefficient(value, error, math.inf)
    if n == p:
        return Fit(chi2, 0, stated, 0.0, None)
    # Moments: what chi2 has beyond its expectation.
    trace = float(weight @ _not_forced(z, weight))
    square = max(0.0, (chi2 - (n - p)) / trace)
    value, error, rest = _weighted(z, x, 1.0 / (s**2 + square))
    error *= math.sqrt(max(1.0, rest / (n - p)))
    scattered = _coefficient(value, error, n - p)
    return Fit(chi2, n - p, stated, math.sqrt(square), scattered)


def _weighted(z, x: np.ndarray, weight: np.ndarray) -> tuple:
    """The last coefficient, its standard error, and chi-square."""
    share = weight / weight.sum()
    middle = share @ x
    if z is None:
        error = 1.0 / math.sqrt(weight.sum())
        return float(middle), error, float(weight @ (x - middle) ** 2)
    off = z - share @ z
    square = float(weight @ off**2)
    slope = float((weight * off) @ (x - middle)) / square
    rest = x - middle - slope * off
    return slope, 1.0 / math.sqrt(square), float(weight @ rest**2)


def _not_forced(z, weight: np.ndarray) -> np.ndarray:
    """One less the leverage of each point (n,): how far the others alone
    determine the model.
    """
    others = np.where(np.eye(len(weight), dtype=bool), 0.0, weight)
    left = others.sum(axis=1) / weight.sum()
    if z is None:
        return left
    middle = others @ z / others.sum(axis=1)
    squares = np.sum(others * (z - middle[:, None]) ** 2, axis=1)
    off = z - weight @ z / weight.sum()
    return left * squares / float(weight @ off**2)


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
    return fit_linear(None, x, s)


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
                found = optimize.brentq(left, 0.0, far, (target,), maxiter=1000)
                return float(found)
            far *= 2.0
        return math.inf

    return where(low), where(high)


def fit_line(t: np.ndarray, x: np.ndarray, s: np.ndarray) -> Fit | None:
    """A weighted line; its coefficient is the slope, per unit of t.

    None where there are fewer than two times.
    """
    if len(x) < 2 or np.ptp(t) == 0.0:
        return None
    found = fit_linear((t - t.mean()) / np.ptp(t), x, s)
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
        k: fit_linear((np.arange(n) >= k).astype(float), x, s)
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
    # Of the lower tail: the smallest levels are lost beside 1.
    return coefficient.error * (power - _quantile(level / 2.0, freedom))


def holm(p: list[float]) -> list[float]:
    """Probabilities corrected for their number, Holm's step-down."""
    order = sorted(range(len(p)), key=lambda i: p[i])
    found, largest = [1.0] * len(p), 0.0
    for rank, i in enumerate(order):
        largest = max(largest, min(1.0, (len(p) - rank) * p[i]))
        found[i] = largest
    return found

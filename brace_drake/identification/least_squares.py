"""Bounded nonlinear least squares when residuals come from simulations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import lsq_linear

# Columns whose singular values are smaller, relative to the largest of unit
# columns, are copies of others.
_COPY = 1e-8
# Rows at a time that stay in a processor's cache, with dozens of columns.
_ROWS = 2000
# A Jacobian is kept while steps bring this share of the decrease that it
# predicts, and take this share of the cost: less where its columns are many.
_KEPT = 0.7
_FEW, _FAST, _FAST_OF_MANY = 12, 0.5, 0.2
# Of many columns combinations are hardly told of, and steps along them go too
# far: where a step leaves more than this many times what was predicted,
# these shares of the diagonal of J'J are added and the best step is taken
# (Marquardt, SIAM J. Appl. Math. 11, 1963).
_AS_PREDICTED = 1.1
_DAMPED = (1e-4, 1e-3, 1e-2)
# Noise in a Jacobian, as of drives that stick, makes steps too short: one of
# few parameters that brings so many times the predicted decrease is tried so
# much longer.
_EXCEEDED, _LONGER = 1.3, (2.0, 4.0)
# A limit acts on one side of it only: of a step that leaves more than so many
# times what was predicted these shares are tried.
_MISSED, _SHORTER = 2.0, (0.25, 0.5, 0.75)


def calc_triangle(columns: Sequence[np.ndarray]) -> np.ndarray:
    """R of A = Q R, A the arrays beside each other.

    Block by block of rows, then of the triangles below each other: as exact as
    Householder's reflections of the whole, without their ways through memory
    (Demmel, Grigori, Hoemmen, Langou, Communication-optimal parallel and
    sequential QR and LU factorizations, SIAM J. Sci. Comput. 34, 2012).

    Args:
        columns: Arrays (m,) or (m, n_i).

    Returns:
        (min(m, n), n), n the sum of all n_i.
    """
    rows = len(columns[0])
    triangles = [
        np.linalg.qr(
            np.column_stack([c[at : at + _ROWS] for c in columns]), mode="r"
        )
        for at in range(0, rows, _ROWS)
    ]
    if len(triangles) == 1:
        return triangles[0]
    return np.linalg.qr(np.vstack(triangles), mode="r")


class Batch(Protocol):
    """Residual vectors of many points at once, None where one failed.

    `coarse` allows a cheaper simulation, good enough for differences; then
    all points are evaluated with that.
    """

    def __call__(
        self, points: Sequence[np.ndarray], coarse: bool = False
    ) -> list[np.ndarray | None]: ...


@dataclass(frozen=True)
class LeastSquaresSolution:
    """Where a bounded Gauss-Newton search ended.

    Attributes:
        z: Scaled parameters (n,).
        residual: There (m,).
        jacobian: (m, n); rows of residuals, columns of scaled parameters; None
            where it was not kept.
        iterations: Steps taken.
        converged: Whether the last step was negligible.
    """

    z: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray | None
    iterations: int
    converged: bool

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


def difference_jacobian(
    batch: Batch,
    z: np.ndarray,
    steps: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Forward differences of the residual (m, n).

    A step that would leave the upper limit goes the other way; a point that
    fails leaves a zero column.
    """
    signed = np.where(z + steps > upper, -steps, steps)
    points = [z, *(z + np.diag(signed))]
    base, *moved = batch(points, coarse=True)
    return np.column_stack(
        [
            np.zeros_like(base) if r is None else (r - base) / h
            for r, h in zip(moved, signed, strict=True)
        ]
    )


def step_within(triangle, z, limits, share: float = 0.0) -> np.ndarray:
    """Least-squares step inside the limits and a box of given radius.

    Args:
        triangle: Of Jacobian and residual beside each other, `calc_triangle`.
        z: Where it begins.
        limits: Lower and upper limits, radius (n,).
        share: Of the diagonal of J'J, added to it.
    """
    lower, upper, radius = limits
    matrix, right = triangle[:-1, :-1], -triangle[:-1, -1]
    low = np.maximum(lower - z, -radius)
    high = np.minimum(upper - z, radius)
    high = np.maximum(high, low + 1e-15)
    if share > 0.0:
        size = np.linalg.norm(matrix, axis=0)
        matrix = np.vstack([matrix, np.diag(np.sqrt(share) * size)])
        right = np.append(right, np.zeros(len(z)))
    return lsq_linear(matrix, right, (low, high), method="bvls").x


def solve_gauss_newton(
    batch: Batch,
    start: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    steps: np.ndarray,
    radius: np.ndarray,
    differentiate: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    known: tuple[np.ndarray, np.ndarray] | None = None,
    max_iterations: int = 12,
    tolerance: float = 3e-6,
    first: int = 0,
) -> LeastSquaresSolution:
    """Minimises the sum of squares of a simulated residual in a box.

    Gauss-Newton; a step that does not help is halved up to three times, of
    many parameters damped before; of few parameters one that brings more than
    predicted is lengthened, one that leaves far more is tried in parts. The
    Jacobian is kept (the chord method) as long as steps bring what it predicts;
    the search ends when a step with a new one brings nothing.

    Args:
        batch: Residuals of many points at once.
        start, lower, upper: Scaled parameters (n,).
        steps: Of the differences (n,).
        radius: Largest step of one iteration (n,).
        differentiate: Jacobian from parameters and the residual there;
            forward differences of all parameters by default.
        known: Residual and Jacobian at the start, where they are known.
        max_iterations: Limit.
        tolerance: On the relative decrease of the cost.
        first: So many parameters come first that may stay where they are:
            where few are not as predicted, the others are moved alone too.

    Raises:
        ValueError: The residual could not be evaluated at the start.
    """
    z = np.clip(start, lower, upper)
    residual, jacobian = known or (batch([z])[0], None)
    if residual is None:
        raise ValueError("the residual cannot be evaluated at the start")
    if differentiate is None:

        def differentiate(z, residual):
            return difference_jacobian(batch, z, steps, upper)

    converged, stale, iteration = False, jacobian is None, 0
    while iteration < max_iterations:
        iteration += 1
        fresh = stale
        if stale:
            # The last one goes first: it takes as much memory.
            jacobian = None
            jacobian = differentiate(z, residual)
        cost = float(residual @ residual)
        limits = lower, upper, radius
        triangle = calc_triangle([jacobian, residual])
        step = step_within(triangle, z, limits)
        left = residual + jacobian @ step
        rest = float(left @ left)
        accepted = _improve(batch, z, step, triangle, limits, cost, rest, first)
        decrease = 0.0
        if accepted is not None:
            z, residual = accepted
            decrease = cost - float(residual @ residual)
        small = decrease < tolerance * max(cost, 1.0)
        if small and fresh:
            converged = True
            break
        fast = _FAST if len(z) <= _FEW else _FAST_OF_MANY
        slow = decrease < fast * cost
        stale = small or slow or decrease < _KEPT * (cost - rest)
    return LeastSquaresSolution(z, residual, jacobian, iteration, converged)


def _improve(batch, z, step, triangle, limits, cost, predicted_rest, first):
    """The point and residual of a step that lowers the cost, or None.

    The full step, else halves of it; of many parameters damped steps before,
    where the full one leaves more than predicted. Of few parameters one that
    brings more than predicted is lengthened, and of one that leaves far more
    than predicted parts are tried.
    """
    lower, upper, _ = limits
    is_many, tries, full = len(z) > _FEW, 4, step
    if is_many:
        tries, points = 3, [np.clip(z + step, lower, upper)]
        best = _least(points, batch(points))
        if best is None or _cost_of(best) > _AS_PREDICTED * predicted_rest:
            steps = [step_within(triangle, z, limits, s) for s in _DAMPED]
            points = [np.clip(z + s, lower, upper) for s in steps]
            best = _least(points, batch(points), best)
        if best is not None and _cost_of(best) < cost:
            return best
        step = 0.5 * step
    for _ in range(tries):
        points = [np.clip(z + step, lower, upper)]
        best = _least(points, batch(points))
        if best is not None and _cost_of(best) < cost:
            break
        step, best = 0.5 * step, None
    if best is None or is_many:
        return best
    if cost - _cost_of(best) > _EXCEEDED * (cost - predicted_rest):
        others = [f * full for f in _LONGER]
    elif _cost_of(best) > _MISSED * predicted_rest:
        others = [f * step for f in _SHORTER]
    else:
        return best
    if first:
        # By sensitivities from elsewhere the first may go a wrong way.
        others.append(np.where(np.arange(len(z)) < first, 0.0, step))
    points = [np.clip(z + s, lower, upper) for s in others]
    return _least(points, batch(points), best)


def _least(points, residuals, best=None):
    """The point and residual of least cost, of those that there are."""
    found = zip(points, residuals, strict=True)
    known = [f for f in found if f[1] is not None]
    known = known if best is None else [best, *known]
    return min(known, key=_cost_of, default=None)


def _cost_of(point_and_residual) -> float:
    residual = point_and_residual[1]
    return float(residual @ residual)


def orthonormal_basis(columns: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the span of columns (rows, n): (rows, rank)."""
    size = np.linalg.norm(columns, axis=0)
    columns = columns[:, size > 0.0] / size[size > 0.0]
    if columns.shape[1] == 0:
        return columns
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    return left[:, values > _COPY * values[0]]


def beyond(vectors: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """What of vectors (rows,) or (rows, n) lies outside a basis."""
    return vectors - basis @ (basis.T @ vectors)

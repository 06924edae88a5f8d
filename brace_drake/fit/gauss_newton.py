"""Bounded nonlinear least squares when residuals come from simulations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import lsq_linear


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
        jacobian: (m, n); rows of residuals, columns of scaled parameters.
        iterations: Steps taken.
        converged: Whether the last step was negligible.
        first_jacobian: At the start.
    """

    z: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    iterations: int
    converged: bool
    first_jacobian: np.ndarray

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


def difference_jacobian(
    batch: Batch,
    z: np.ndarray,
    steps: np.ndarray,
    upper: np.ndarray,
    columns: Sequence[int],
) -> dict[int, np.ndarray]:
    """Forward differences of the residual along chosen columns.

    A step that would leave the upper limit goes the other way; a point that
    fails leaves a zero column.
    """
    signed = np.where(z + steps > upper, -steps, steps)
    points = [z]
    for i in columns:
        point = z.copy()
        point[i] += signed[i]
        points.append(point)
    base, *moved = batch(points, coarse=True)
    return {
        i: np.zeros_like(base) if r is None else (r - base) / signed[i]
        for i, r in zip(columns, moved, strict=True)
    }


def bounded_step(
    jacobian: np.ndarray,
    residual: np.ndarray,
    z: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    radius: np.ndarray,
) -> np.ndarray:
    """Least-squares step inside the limits and a box of given radius."""
    # The normal equations by QR keep the small problem exact and cheap.
    r = np.linalg.qr(np.column_stack([jacobian, residual]), mode="r")
    triangle, target = r[:-1, :-1], -r[:-1, -1]
    low = np.maximum(lower - z, -radius)
    high = np.minimum(upper - z, radius)
    high = np.maximum(high, low + 1e-15)
    return lsq_linear(triangle, target, (low, high), method="bvls").x


def solve_gauss_newton(
    batch: Batch,
    start: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    steps: np.ndarray,
    radius: np.ndarray,
    known: np.ndarray | None = None,
    refresh: Sequence[int] | None = None,
    renew: bool = True,
    max_iterations: int = 12,
    tolerance: float = 3e-6,
) -> LeastSquaresSolution:
    """Minimises the sum of squares of a simulated residual in a box.

    Gauss-Newton with forward differences; a step that does not help is halved
    up to three times. Columns left out of `refresh` keep their `known` value
    (the chord method) as long as that helps; the search ends only when a step
    with all columns anew brings nothing.

    Args:
        batch: Residuals of many points at once.
        start, lower, upper: Scaled parameters (n,).
        steps: Of the differences (n,).
        radius: Largest step of one iteration (n,).
        known: Jacobian at the start (m, n), where columns are known already.
        refresh: Columns to difference in every iteration; all by default.
        renew: Otherwise those columns are differenced once.
        max_iterations: Limit.
        tolerance: On the predicted relative decrease of the cost.

    Raises:
        ValueError: The residual could not be evaluated at the start.
    """
    z = np.clip(start, lower, upper)
    (residual,) = batch([z])
    if residual is None:
        raise ValueError("the residual cannot be evaluated at the start")
    everything = list(range(len(z)))
    few = everything if refresh is None else list(refresh)
    jacobian = np.zeros((len(residual), len(z)))
    if known is not None:
        jacobian[:, : known.shape[1]] = known
    columns, converged, iteration = few, False, 0
    first_jacobian = None
    for iteration in range(1, max_iterations + 1):
        found = {}
        if renew or iteration == 1:
            found = difference_jacobian(batch, z, steps, upper, columns)
        for i, column in found.items():
            jacobian[:, i] = column
        step = bounded_step(jacobian, residual, z, lower, upper, radius)
        cost = float(residual @ residual)
        accepted = _first_improvement(batch, z, step, cost, lower, upper)
        decrease = 0.0
        if accepted is not None:
            z, residual = accepted
            decrease = cost - float(residual @ residual)
        if first_jacobian is None:
            first_jacobian = jacobian.copy()
        small = decrease < tolerance * max(cost, 1.0)
        if small and (not renew or len(columns) == len(z)):
            converged = True
            break
        # Old columns have served their turn when they bring no more.
        columns = everything if small else few
    return LeastSquaresSolution(
        z, residual, jacobian, iteration, converged, first_jacobian
    )


def _first_improvement(batch, z, step, cost, lower, upper):
    """The full step or the first of its halves that lowers the cost."""
    for scale in (1.0, 0.5, 0.25, 0.125):
        trial = np.clip(z + scale * step, lower, upper)
        (residual,) = batch([trial])
        if residual is not None and residual @ residual < cost:
            return trial, residual
    return None

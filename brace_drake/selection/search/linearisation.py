"""A fit linearised: what a small change of it takes off the residual."""

from __future__ import annotations

from copy import copy

import numpy as np
from scipy.optimize import lsq_linear

from brace_drake.core.errors import BraceError
from brace_drake.devices.stretch import stretch_of
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities
from brace_drake.selection import thresholds
from brace_drake.selection.tolerated import left_by, strained

# Relative to the largest, what is added to the diagonal of small systems.
_RIDGE = 1e-12


class Linearisation:
    """A fit, its sensitivities, and what it leaves that no change of it takes.

    Parameters of the fit stay within their limits: one that is at its limit
    takes nothing that lies beyond.

    Args:
        evaluator: Over the fit runs.
        base: The nominal fit, or one whose effects stay in.

    Attributes:
        residual: Of the fit at the coarse plant step (rows,).
        excess: Sum of squares above noise of what no change of the fit's
            parameters takes.
        remaining: The same, strained; not below 0.
        whole_tolerances: Of all numbers, as the evaluator has them.

    Raises:
        BraceError: The twin breaks down there at the coarse plant step.
    """

    def __init__(self, evaluator: Evaluator, base: CandidateFit):
        self.evaluator, self.base = evaluator, base
        self.whole_tolerances = evaluator.tolerances
        self.rows = evaluator.ends[-1]
        problem = CandidateProblem(
            evaluator, base.effects, base.values, base.spread
        )
        self.tolerances = problem.tolerances
        z = base.solution.z
        self._room = problem.lower - z, problem.upper - z
        (residual,) = problem.batch([z], coarse=True)
        if residual is None:
            raise BraceError("the twin breaks down at the fit of its causes")
        self.residual = residual[: self.rows]
        self._smooth = None
        if problem.sticks_little:
            (smooth,) = problem.batch([z], coarse=True, smooth=True)
            self._smooth = None if smooth is None else smooth[: self.rows]
        jacobian = base.solution.jacobian[: self.rows]
        self._sensitivities = self._seen(jacobian, base.tolerances)
        self._gram = self._sensitivities.T @ self._sensitivities
        self._change: np.ndarray | None = None
        self._beside: dict[int, Linearisation] = {}
        self.noise = evaluator.count * evaluator.noise_level(
            base.uses, coarse=True
        )
        self._derive()

    def _derive(self) -> None:
        """What follows from residual and sensitivities."""
        self._slope = self._along(self.residual)
        self._square = float(self.residual @ self.residual)
        step = _minimise(self._gram, self._slope, *self._room)
        self.excess = self._left(self._gram, self._slope, step)
        self._stretch = self._stretch_at(self._moved(step))
        count = self.evaluator.count
        left = strained(self.excess, self._stretch, count)
        self.remaining = max(0.0, left)

    def _left(self, gram, slope, x: np.ndarray) -> float:
        """Squares above noise after a change x of parameters."""
        change = 2.0 * slope @ x + x @ gram @ x
        return float(self._square + change - self.noise)

    def _moved(self, step: np.ndarray) -> np.ndarray:
        """Change of the residual by a step of the parameters (rows,)."""
        moved = self._sensitivities @ step
        if self._change is not None:
            moved += self.tolerances.basis @ (self._change @ step)
        return moved

    def _along(self, residual: np.ndarray) -> np.ndarray:
        """Sensitivities times a residual (n,)."""
        along = self._sensitivities.T @ residual
        if self._change is not None:
            along += self._change.T @ (self.tolerances.basis.T @ residual)
        return along

    def _stretch_at(self, change: np.ndarray) -> float:
        """Of tolerances, where the residual has changed by so much."""
        if self.tolerances is None:
            return 0.0
        return stretch_of(self.tolerances, self.residual + change)

    def _seen(
        self, rows: np.ndarray, before: LinearTolerances | None
    ) -> np.ndarray:
        """Rows as whitened of the tolerances here, not of others before."""
        if before is self.tolerances or self.tolerances is None:
            return rows
        n, out = self.evaluator.ends[-1], rows.copy()
        known = rows[:n] if before is None else before.colour(rows[:n])
        out[:n] = self.tolerances.whiten(known)
        return out

    def beside(self, tolerances: LinearTolerances | None) -> Linearisation:
        """The same as a candidate sees it, which stands for some of the
        numbers known to tolerances itself.
        """
        if tolerances is self.tolerances:
            return self
        if id(tolerances) not in self._beside:
            other = copy(self)
            # One that held itself would stay in memory.
            other._beside = {}
            other.tolerances = tolerances
            other.residual = other._seen(self.residual, self.tolerances)
            if self._smooth is not None:
                other._smooth = other._seen(self._smooth, self.tolerances)
            other._whiten_anew(self.tolerances)
            other._derive()
            self._beside[id(tolerances)] = other
        return self._beside[id(tolerances)]

    def _whiten_anew(self, before: LinearTolerances) -> None:
        """Takes the sensitivities as whitened of the tolerances here, which
        have the basis of those before: what they are in that alone changes.
        """
        basis = self.tolerances.basis
        along = basis.T @ self._sensitivities
        change = self.tolerances.from_whitened(before) @ along
        shared = along.T @ change
        self._gram = self._gram + shared + shared.T + change.T @ change
        self._change = change

    @property
    def is_exact(self) -> bool:
        """Whether the fit leaves nothing for another effect to explain."""
        count = self.evaluator.count
        return left_by(self.base, count) <= thresholds.TWIN_ERROR * count

    def predict_excess(
        self,
        problem: CandidateProblem,
        z: np.ndarray,
        residual: np.ndarray,
        either_way: bool = False,
    ) -> tuple[float, float]:
        """What is left at the best place on the straight way to a candidate.

        On the way the fit's parameters follow, within their limits.

        Args:
            problem: The candidate's.
            z: Where it stands.
            residual: There.
            either_way: Whether the way goes on behind the fit, as for an
                effect of either sign.

        Returns:
            Sum of squares above noise at that place, strained, and how far it
            is, 1 at the candidate itself.
        """
        self = self.beside(problem.tolerances)
        way, noise = self._way_to(problem, z, residual)
        whole = float(way @ way)
        # Noise that the way has of its own is no part of it.
        if whole <= noise:
            return self.remaining, 1.0
        left, x = self._best_on(way, whole - noise, either_way)
        if left < -thresholds.COARSE_PREDICTION * self.evaluator.count:
            # More than there is: what the way is made of is mostly noise.
            left, x = self._best_on(way, whole, either_way)
        # Far on a straight way tolerances tell nothing: they are stretched no
        # more than at its beginning.
        change = self._moved(x[:-1]) + way * x[-1]
        stretch = min(self._stretch, self._stretch_at(change))
        left = strained(left, stretch, self.evaluator.count)
        return left, float(x[-1])

    def _way_to(
        self, problem: CandidateProblem, z: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """The way to a candidate, and the squares of noise in it.

        Where drives stick no more than within tolerances it is that of a twin
        whose drives do not: how they stick by chance is no part of it.
        """
        is_smooth = self._smooth is not None and problem.sticks_little
        if is_smooth and not problem.effects[-1].dithered:
            (there,) = problem.batch([z], coarse=True, smooth=True)
            if there is not None:
                return there[: self.rows] - self._smooth, 0.0
        way = residual[: self.rows] - self.residual
        return way, self.added_noise(problem, z)

    def _best_on(
        self, way: np.ndarray, square: float, either_way: bool
    ) -> tuple[float, np.ndarray]:
        """Least excess along a way of a given squared length, and where, the
        part of the way last.
        """
        cross = self._along(way)
        gram = np.block([[self._gram, cross[:, None]], [cross, square]])
        slope = np.append(self._slope, way @ self.residual)
        reach = thresholds.REACH
        low = np.append(self._room[0], -reach if either_way else 0.0)
        high = np.append(self._room[1], reach)
        x = _minimise(gram, slope, low, high)
        return self._left(gram, slope, x), x

    def added_noise(self, problem: CandidateProblem, z: np.ndarray) -> float:
        """Squares of noise in a way, of replays that are dithered."""
        _, uses = problem.split(z)
        count = self.evaluator.count
        level = self.evaluator.noise_level(uses, coarse=True)
        return max(0.0, level * count - self.noise)

    def differentiate(
        self, problem: CandidateProblem, z: np.ndarray, residual: np.ndarray
    ) -> np.ndarray:
        """Jacobian of a candidate with the fit's columns kept."""
        seen = self.beside(problem.tolerances)
        n = len(seen._slope)
        out = np.zeros((len(residual), len(z)), order="F")
        out[: self.rows, :n] = seen._sensitivities
        if seen._change is not None:
            for column, change in zip(out.T, seen._change.T, strict=False):
                column[: self.rows] += seen.tolerances.basis @ change
        prior = problem.prior_jacobian()
        out[len(out) - len(prior) :] = prior
        out[:, n:] = calc_sensitivities(problem, z, n, residual)
        return out


def _minimise(
    gram: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """x within limits that makes x' gram x + 2 slope' x least (n,)."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    scaled = gram * np.outer(scale, scale)
    scaled[np.diag_indices(len(scaled))] += _RIDGE
    # What noise was taken off may leave a little less than nothing.
    value, vector = np.linalg.eigh(scaled)
    value = np.maximum(value, _RIDGE)
    root = np.sqrt(value)[:, None] * vector.T
    target = -(vector.T @ (slope * scale)) / np.sqrt(value)
    limits = np.minimum(low, 0.0) / scale, np.maximum(high, 1e-12) / scale
    return lsq_linear(root, target, limits, method="bvls").x * scale

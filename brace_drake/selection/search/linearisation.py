"""The fit that a race of causes sets out from, and what is near it."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from brace_drake.core.errors import BraceError
from brace_drake.design.separation import beyond
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection.measures import is_exact

# A promise looks at most this many times as far as the start.
_REACH = 30.0
# About as near as a coarse search comes, in floors: what is promised to leave
# less than noise by more is no promise.
_NEAR = 0.03
# Relative to the largest, what is added to the diagonal of small systems.
_RIDGE = 1e-12


class Ground:
    """A fit, its sensitivities, and what it leaves that no change of it takes.

    Parameters of the fit stay within their limits: one that is at its limit
    takes nothing that lies beyond.

    Args:
        evaluator: Over the fit runs.
        leader: The nominal fit, or one whose effects stay in.
        with_prior: Whether what the leader's parameters cost counts too. Where
            dozens of them cover what another effect does, that is where it
            shows.

    Raises:
        BraceError: The twin breaks down there at the coarse plant step.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        leader: CandidateFit,
        with_prior: bool = False,
    ):
        self.evaluator, self.leader = evaluator, leader
        self.rows, self._with_prior = evaluator.ends[-1], with_prior
        if with_prior:
            self.rows += leader.num_prior
        self.sensitivities = leader.solution.jacobian[: self.rows]
        problem = CandidateProblem(evaluator, leader.effects, leader.values)
        if leader.spread is not None:
            problem.spread = leader.spread / problem.spread_scale
        z = leader.solution.z
        self._room = problem.lower - z, problem.upper - z
        (residual,) = problem.batch([z], coarse=True)
        if residual is None:
            raise BraceError("the twin breaks down at the fit of its causes")
        self.residual = residual[: self.rows]
        self._gram = self.sensitivities.T @ self.sensitivities
        self._slope = self.sensitivities.T @ self.residual
        self._square = float(self.residual @ self.residual)
        step = _minimise(self._gram, self._slope, *self._room)
        inside = (step > self._room[0]) & (step < self._room[1])
        seen = np.linalg.norm(self.sensitivities, axis=0) > 0.0
        self.basis = np.linalg.qr(self.sensitivities[:, inside & seen])[0]
        moved = self.residual + self.sensitivities @ np.where(inside, 0, step)
        self.left = self.beyond(moved)
        self.noise = evaluator.count * evaluator.noise_level(
            leader.uses, coarse=True
        )
        self.excess = float(self.left @ self.left) - self.noise
        self.there = max(0.0, self.excess)

    def beyond(self, vectors: np.ndarray) -> np.ndarray:
        """What of residuals or columns no change of the leader's fit takes."""
        return beyond(vectors[: self.rows], self.basis)

    @property
    def is_exact(self) -> bool:
        """Whether the leader leaves nothing for another effect to explain."""
        return not self._with_prior and is_exact(self.evaluator, self.leader)

    def foresee(
        self,
        problem: CandidateProblem,
        z: np.ndarray,
        residual: np.ndarray,
        either_way: bool = False,
    ) -> tuple[float, float]:
        """What is left at the best place on the straight way to a candidate.

        On the way the leader's parameters follow, within their limits.

        Args:
            problem: The candidate's.
            z: Where it stands.
            residual: There.
            either_way: Whether the way goes on behind the leader, as for an
                effect of either sign.

        Returns:
            Sum of squares above noise at that place, and how far it is, 1 at
            the candidate itself.
        """
        way = residual[: self.rows] - self.residual
        whole, noise = float(way @ way), self.added_noise(problem, z)
        # Noise that the way has of its own is no part of it.
        if whole <= noise:
            return self.there, 1.0
        left, far = self._go(way, whole - noise, either_way)
        if left < -_NEAR * self.evaluator.count:
            # More than there is: what the way is made of is mostly noise.
            left, far = self._go(way, whole, either_way)
        return left, far

    def _go(
        self, way: np.ndarray, length: float, either_way: bool
    ) -> tuple[float, float]:
        """`foresee` along a way of a given squared length."""
        cross = self.sensitivities.T @ way
        gram = np.block([[self._gram, cross[:, None]], [cross, length]])
        slope = np.append(self._slope, way @ self.residual)
        reach = (-_REACH if either_way else 0.0), _REACH
        low, high = (
            np.append(r, e) for r, e in zip(self._room, reach, strict=True)
        )
        x = _minimise(gram, slope, low, high)
        left = self._square + 2.0 * slope @ x + x @ gram @ x - self.noise
        return float(left), float(x[-1])

    def added_noise(self, problem: CandidateProblem, z: np.ndarray) -> float:
        """Squares of noise in a way, of replays that are dithered."""
        _, uses = problem.split(z)
        count = self.evaluator.count
        level = self.evaluator.noise_level(uses, coarse=True)
        return max(0.0, level * count - self.noise)

    def differentiate(self, problem: CandidateProblem):
        """Jacobian with the leader's columns kept."""
        n = self.sensitivities.shape[1]

        def jacobian(z, residual):
            columns = problem.columns(z, n, residual)
            out = np.zeros((len(residual), len(z)))
            out[: self.rows, :n] = self.sensitivities
            prior = problem.prior_jacobian()
            out[len(out) - len(prior) :] = prior
            out[:, n:] = columns
            return out

        return jacobian


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

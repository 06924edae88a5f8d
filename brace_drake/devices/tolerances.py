"""Numbers that are known to a tolerance: nuisance parameters, marginalised.

A number that is off by t_i deviations changes the weighted residual by the
column j_i t_i, and t has a unit normal prior. So the residual of a right twin
has the covariance I + J J', and whitened by its inverse root it is pure noise
again: nothing of it is taken for a gap. While small that costs nothing per
hypothesis (Kennedy and O'Hagan, Bayesian calibration of computer models, J. R.
Stat. Soc. B 63, 2001; Rasmussen and Williams, Gaussian Processes for Machine
Learning, section 2.7).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.stack import Use


@dataclass(frozen=True)
class LinearTolerances:
    """What numbers within their tolerances change of weighted residuals.

    Attributes:
        nuisances: The numbers, k of them.
        left: Orthonormal directions (rows, k), first of the largest change.
        sizes: Change of each by one deviation (k,).
        right: Directions among the numbers (k, k), rows.
        shrink: Of each direction what whitening takes off (k,).
    """

    nuisances: tuple[Nuisance, ...]
    left: np.ndarray
    sizes: np.ndarray
    right: np.ndarray
    shrink: np.ndarray = field(init=False)

    def __post_init__(self):
        shrink = 1.0 - 1.0 / np.sqrt(1.0 + self.sizes**2)
        vars(self)["shrink"] = shrink

    def whiten(self, residual: np.ndarray) -> np.ndarray:
        """(I + J J')^(-1/2) of a weighted residual (rows,) or (rows, n)."""
        along = (self.left.T @ residual).T * self.shrink
        return residual - self.left @ along.T

    def colour(self, whitened: np.ndarray) -> np.ndarray:
        """The inverse of `whiten`."""
        along = (self.left.T @ whitened).T
        along = along * (self.shrink / (1.0 - self.shrink))
        return whitened + self.left @ along.T

    def estimate(self, whitened: np.ndarray, noise: float = 1.0) -> np.ndarray:
        """Posterior means t of the numbers, in their deviations (k,).

        Args:
            whitened: Residual after `whiten`.
            noise: Variance of what else there is in the residual: 1 for noise
                alone, more where the twin leaves more.
        """
        along = self.left.T @ whitened / (1.0 - self.shrink)
        return -self.right.T @ (self.sizes / (noise + self.sizes**2) * along)

    def errors(self, noise: float = 1.0) -> np.ndarray:
        """Posterior standard deviations of the same (k,)."""
        told = 1.0 / (1.0 + self.sizes**2 / noise)
        return np.sqrt(np.sum(self.right**2 * told[:, None], axis=0))


def linearise_tolerances(
    evaluator,
    nuisances: Sequence[Nuisance],
    subject: np.ndarray,
    uses: Sequence[Use] = (),
) -> LinearTolerances | None:
    """The change of all runs by each number, at a subject and with effects.

    None where no number has a tolerance, or the twin breaks down.

    Args:
        evaluator: Over the runs.
        nuisances: Numbers with a tolerance.
        subject: Values of the subject's parameters.
        uses: Effects that are there.
    """
    if not nuisances:
        return None
    tasks = [(p, n) for n in nuisances for p in evaluator.prepared]
    try:
        changes = evaluator.map(
            lambda p, n: evaluator.change(p, subject, uses, n.uses),
            tasks,
        )
    except BraceError:
        return None
    runs = len(evaluator.prepared)
    columns = np.column_stack(
        [
            np.concatenate(changes[at : at + runs])
            for at in range(0, len(changes), runs)
        ]
    )
    gram = columns.T @ columns
    squares, directions = np.linalg.eigh(gram)
    kept = squares > 1e-12 * squares[-1]
    sizes = np.sqrt(squares[kept])[::-1]
    right = directions[:, kept].T[::-1]
    left = columns @ (right.T / sizes)
    return LinearTolerances(tuple(nuisances), left, sizes, right)

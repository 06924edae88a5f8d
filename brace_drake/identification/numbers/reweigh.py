"""Fits whose tolerances are weighed beside what is left along them.

What an effect does that the twin has not leaves more along the numbers known to
a tolerance than the noise of the readings: weighed against that alone, numbers
are put off by many tolerances to take a part of it. The variance of what is
left is estimated from each fit's own residual (empirical Bayes; Gelman et al.,
Bayesian Data Analysis, section 5.1).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.devices.stretch import noise_along, variance_over
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit


def noise_left(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Variance that a fit leaves along its numbers, at least 1.

    What is left once the numbers are where they are likeliest.
    """
    known = fit.tolerances
    whitened = fit.solution.residual[: evaluator.ends[-1]]
    along = known.along(whitened)
    off = known.estimate(along, known.noise)
    rest = known.colour(whitened) + known.basis @ (known.columns @ off)
    return variance_along(known, along, evaluator.excess(rest, fit.uses))


def variance_along(
    known: LinearTolerances, along: np.ndarray, excess: float
) -> float:
    """Variance of all else along numbers: as it shows along most of them, and
    no less than if all that is left lay there.

    Args:
        known: The numbers.
        along: Residual with all of them at 0, in their basis (k,).
        excess: Sum of squares above noise that is left.
    """
    least = variance_over(excess, len(known.nuisances))
    return max(noise_along(known, along), least)


def reweigh(
    evaluator: Evaluator, fit: CandidateFit, noise: float
) -> CandidateFit:
    """The same fit with its tolerances weighed beside another variance; it
    stands where it stood.
    """
    n, before = evaluator.ends[-1], fit.tolerances
    after = before.beside_noise(noise)

    def seen(rows: np.ndarray) -> np.ndarray:
        out = rows.copy()
        out[:n] = after.whiten(before.colour(rows[:n]))
        return out

    old = fit.solution
    jacobian = None if old.jacobian is None else seen(old.jacobian)
    new = replace(old, residual=seen(old.residual), jacobian=jacobian)
    more = float(new.residual[:n] @ new.residual[:n])
    more -= float(old.residual[:n] @ old.residual[:n])
    return replace(
        fit, solution=new, tolerances=after, excess=fit.excess + more
    )

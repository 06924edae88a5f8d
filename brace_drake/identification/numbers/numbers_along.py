"""Fits of parameters together with numbers that are known to a tolerance.

Where the twin is not linear in its numbers, as in anchors where drives stick,
a linear fit leaves what they do beyond it. Here the numbers are fitted together
with the parameters: Gauss-Newton in all of them with the columns kept (the
chord method; Kelley, Solving Nonlinear Equations with Newton's Method, SIAM
2003), and the twin replayed with the fitted numbers. Minimised is

    |r(z, t)|^2 + v |t|^2

over parameters z and numbers t in tolerances, where r is the residual of the
twin as it stands and v the variance of what it leaves along the numbers: with
1 in its place they would take what the twin's laws are not exact to.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import (
    CandidateFit,
    correct_fit,
    finish_fit,
)
from brace_drake.identification.held_out import check_fit
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    calc_triangle,
    step_within,
)
from brace_drake.identification.numbers.reweigh import (
    noise_left,
    reweigh,
    variance_along,
)
from brace_drake.identification.prior_check import beside_noise
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities

_STEPS = 10
# Parts of a step that are tried; one that takes less than this share of what is
# minimised is the last.
_PARTS, _END = (1.0, 0.5, 0.25), 0.02


def fit_numbers_along(
    evaluator: Evaluator, fit: CandidateFit, is_anew: bool
) -> CandidateFit | None:
    """A fit led on with its numbers; None where the twin breaks down.

    At its end the numbers are weighed beside the noise of the readings alone.

    Args:
        evaluator: Over the fit runs, its tolerances linearised with numbers
            off.
        fit: Where it begins.
        is_anew: Whether the columns of its parameters are taken anew; else
            those that it has are kept.
    """
    problem = CandidateProblem(evaluator, fit.effects, fit.values, fit.spread)
    z, jacobian = fit.solution.z, fit.solution.jacobian
    (residual,) = problem.batch([z], white=False)
    if residual is None:
        return None
    if is_anew:
        jacobian = calc_sensitivities(problem, z)
    plain = problem.coloured(jacobian)
    steps = 0
    while steps < _STEPS:
        moved = _step(problem, z, residual, plain)
        if moved is None:
            break
        steps, (problem, z, residual, taken) = steps + 1, moved
        if taken < _END:
            break
    problem = problem.beside_noise(1.0)
    white = _whitened(problem, residual)
    jacobian = problem.whitened(plain)
    end = LeastSquaresSolution(z, white, jacobian, steps, True)
    fit = replace(finish_fit(problem, end), refined=True)
    return check_fit(evaluator, beside_noise(problem, fit))


def correct_along(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """A fit as `correct_fit` leaves it, with its numbers weighed beside what
    it leaves: beside noise alone, a part of that would be taken for theirs.

    Args:
        evaluator: Over the fit runs; it has the tolerances of the fit.
        fit: That was searched.
    """
    before = evaluator.tolerances
    if before is None or fit.tolerances is None or not fit.is_dithered:
        return correct_fit(evaluator, fit)
    noise = noise_left(evaluator, fit)
    evaluator.tolerances = before.beside_noise(noise)
    corrected = correct_fit(evaluator, reweigh(evaluator, fit, noise))
    evaluator.tolerances = before
    return reweigh(evaluator, corrected, fit.tolerances.noise)


def _step(
    problem: CandidateProblem,
    z: np.ndarray,
    residual: np.ndarray,
    jacobian: np.ndarray,
) -> tuple[CandidateProblem, np.ndarray, np.ndarray, float] | None:
    """The largest part of a step that takes anything: the problem with its
    numbers moved, z, the residual there, and the share that it takes; None
    where none does.

    Minimised are the squares of the residual and v times those of the numbers
    in tolerances, where v is the variance of all else along them.
    """
    evaluator = problem.evaluator
    known, rows = problem.tolerances, residual[: evaluator.ends[-1]]
    along = known.basis.T @ known.around_zero(rows)
    excess = evaluator.excess(rows, problem.split(z)[1])
    noise = variance_along(known, along, excess)
    problem = problem.beside_noise(noise)
    known = problem.tolerances
    if problem.has_spread:
        problem.weigh_alike(excess)
        residual = np.append(rows, problem.prior_rows(z))
        jacobian = np.vstack([jacobian[: len(rows)], problem.prior_jacobian()])

    def cost_of(residual, off):
        return float(residual @ residual) + noise * float(off @ off)

    white = _whitened(problem, residual)
    slopes = problem.whitened(jacobian)
    limits = problem.lower, problem.upper, problem.radius
    step = step_within(calc_triangle([slopes, white]), z, limits)
    left = (white + slopes @ step)[: evaluator.ends[-1]]
    way = known.estimate(known.along(left), noise) - known.off
    cost = cost_of(residual, known.off)
    for part in _PARTS:
        there = problem.with_numbers(known.off + part * way)
        (moved,) = there.batch([z + part * step], white=False)
        if moved is None:
            continue
        after = cost_of(moved, there.tolerances.off)
        if after < cost:
            return there, z + part * step, moved, 1.0 - after / cost
    return None


def _whitened(problem: CandidateProblem, residual: np.ndarray) -> np.ndarray:
    """A residual as it were with all numbers at 0, whitened of tolerances; the
    prior's rows as they are.
    """
    n = problem.evaluator.ends[-1]
    rows = problem.tolerances.around_zero(residual[:n])
    return problem.whitened(np.append(rows, residual[n:]))

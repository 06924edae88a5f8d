"""Fits of parameters together with numbers that are known to a tolerance.

Where the twin is not linear in its numbers, as in anchors where drives stick,
a linear fit leaves what they do beyond it. Here the numbers are fitted together
with the parameters: Gauss-Newton in all of them with the columns kept (the
chord method; Kelley, Solving Nonlinear Equations with Newton's Method, SIAM
2003), and the twin replayed with the fitted numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, finish_fit
from brace_drake.identification.held_out import check_fit
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    calc_triangle,
    step_within,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities

_STEPS = 10
# Parts of a step that are tried; one that takes less than this share of the sum
# of squares is the last.
_PARTS, _END = (1.0, 0.5, 0.25), 0.02


def fit_numbers_along(
    evaluator: Evaluator, fit: CandidateFit, is_anew: bool
) -> CandidateFit | None:
    """A fit led on with its numbers; None where the twin breaks down.

    Args:
        evaluator: Over the fit runs, its tolerances linearised with numbers
            off.
        fit: Where it begins.
        is_anew: Whether the columns of its parameters are taken anew; else
            those that it has are kept.
    """
    problem = CandidateProblem(evaluator, fit.effects, fit.values, fit.spread)
    z, jacobian = fit.solution.z, fit.solution.jacobian
    (residual,) = problem.batch([z])
    if residual is None:
        return None
    if is_anew:
        jacobian = calc_sensitivities(problem, z)
    steps = 0
    while steps < _STEPS:
        moved = _step(problem, z, residual, jacobian)
        if moved is None:
            break
        steps, before = steps + 1, residual @ residual
        problem, z, residual = moved
        if residual @ residual > (1.0 - _END) * before:
            break
    end = LeastSquaresSolution(z, residual, jacobian, steps, True)
    fit = replace(finish_fit(problem, end), refined=True)
    return check_fit(evaluator, fit)


def _step(
    problem: CandidateProblem,
    z: np.ndarray,
    residual: np.ndarray,
    jacobian: np.ndarray,
) -> tuple[CandidateProblem, np.ndarray, np.ndarray] | None:
    """The largest part of a step that takes anything: the problem with its
    numbers moved, z and the residual there; None where none does.
    """
    limits = problem.lower, problem.upper, problem.radius
    step = step_within(calc_triangle([jacobian, residual]), z, limits)
    known, evaluator = problem.tolerances, problem.evaluator
    cost = float(residual @ residual)
    # What the fit leaves counts as noise.
    noise = max(known.noise, cost / evaluator.count)
    left = (residual + jacobian @ step)[: evaluator.ends[-1]]
    way = known.estimate(known.along(left), noise) - known.off
    for part in _PARTS:
        there = problem.with_numbers(known.off + part * way)
        (moved,) = there.batch([z + part * step])
        if moved is not None and moved @ moved < cost:
            return there, z + part * step, moved
    return None

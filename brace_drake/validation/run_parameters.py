"""What every run has of its own, estimated on runs that no fit has seen.

The phase of a breath is no property of the torso but of the moment: on a
validation run it can only be taken from that run. All else stays as fitted.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import solve_gauss_newton
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.run_starts import best_run_starts
from brace_drake.identification.sensitivities import calc_sensitivities

_STEPS = 6


def adapt_to_runs(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """The fit with run parameters of an evaluator's runs, nothing else moved.

    Args:
        evaluator: Over other runs than those of the fit.
        fit: As it is where none of its effects has `run_parameters`.
    """
    if not fit.has_run_parameters:
        return fit
    shared = [v[: len(e.parameters)] for e, v in fit.uses]
    problem = CandidateProblem(evaluator, fit.effects, shared)
    z = problem.join(fit.subject, shared)
    is_own = np.zeros(len(z), dtype=bool)
    for effect in fit.effects:
        for run in range(len(evaluator.prepared)):
            is_own[problem.places_in_run(effect, run)] = True
    for effect in fit.effects:
        z, _ = best_run_starts(problem, z, effect)
    first = int(np.argmax(is_own))

    def differentiate(z, residual):
        out = np.zeros((len(residual), len(z)))
        out[:, first:] = calc_sensitivities(problem, z, first, residual)
        return out * is_own

    solution = solve_gauss_newton(
        partial(problem.batch, coarse=True),
        z,
        problem.lower,
        problem.upper,
        problem.steps,
        np.where(is_own, problem.radius, 0.0),
        differentiate=differentiate,
        max_iterations=_STEPS,
        tolerance=1e-4,
    )
    _, uses = problem.split(solution.z)
    return replace(fit, values=tuple(v for _, v in uses))

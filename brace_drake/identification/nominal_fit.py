"""The nominal twin: the subject fitted, numbers within their tolerances."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.linearise import linearise_tolerances
from brace_drake.devices.tolerances import UsesOff
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import (
    CandidateFit,
    correct_step,
    finish_fit,
    search,
)
from brace_drake.identification.held_out import check_fit
from brace_drake.identification.problem import CandidateProblem

# Linearisations: at the usual subject, and at the fitted one.
_ROUNDS = 2


def fit_nominal(
    evaluator: Evaluator,
    nuisances: Sequence[Nuisance] = (),
    uses_off: UsesOff | None = None,
) -> CandidateFit:
    """Fits the subject's parameters alone.

    Args:
        evaluator: Over the fit runs; its residuals are whitened of the
            nuisances from here on.
        nuisances: Numbers that are known to a tolerance.
        uses_off: Effects of them where they are off, for fits in which they
            bend.
    """
    subject = np.array([p.nominal for p in evaluator.twin.subject])
    for _ in range(_ROUNDS if nuisances else 0):
        evaluator.tolerances = linearise_tolerances(
            evaluator, nuisances, subject, uses_off=uses_off
        )
        problem = CandidateProblem(evaluator, ())
        solution = search(problem, subject / problem.scales)
        subject, _ = problem.split(solution.z)
    problem = CandidateProblem(evaluator, ())
    solution = search(problem, subject / problem.scales)
    fit = correct_step(problem, finish_fit(problem, solution))
    return check_fit(evaluator, fit)

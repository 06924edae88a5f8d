"""What the twin leaves of runs, tolerances apart, and subjects of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.devices.linearise import linearise_tolerances
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities

_STEPS, _END = 12, 1e-3


@dataclass(frozen=True)
class SubjectFit:
    """A subject fitted to some runs, with effects held as they are.

    Attributes:
        runs: Fitted.
        evaluator: Over them, with tolerances.
        subject: Values.
        scaled: The same in their units.
        solution: The search's end.
        level: Mean square of noise alone.
        misfit: Mean square above that.
    """

    runs: tuple[PreparedRun, ...]
    evaluator: Evaluator
    subject: np.ndarray
    scaled: np.ndarray
    solution: LeastSquaresSolution
    level: float

    @property
    def misfit(self) -> float:
        residual = self.solution.residual[: self.evaluator.ends[-1]]
        return float(residual @ residual) / self.evaluator.count - self.level


def make_evaluator(
    device: Device,
    runs: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> Evaluator:
    """Over runs, with the tolerances of the device's numbers, if it has any."""
    evaluator = Evaluator(device.twin, runs, jobs)
    evaluator.tolerances = linearise_tolerances(
        evaluator, device.tolerances(), subject, uses
    )
    return evaluator


class _Held(CandidateProblem):
    """Residuals of the subject alone, beside effects that stay as they are."""

    def __init__(self, evaluator: Evaluator, uses: Sequence[Use]):
        super().__init__(evaluator, ())
        self._uses = tuple(uses)

    def split(self, z):
        return z * self.scales, self._uses


def misfit_of(
    evaluator: Evaluator, subject: np.ndarray, uses: Sequence[Use] = ()
) -> float | None:
    """Mean square above the floor's at a subject; None where it breaks down."""
    problem = _Held(evaluator, uses)
    (residual,) = problem.batch([subject / problem.scales], coarse=True)
    if residual is None:
        return None
    level = evaluator.noise_level(uses, True)
    return float(residual @ residual) / evaluator.count - level


def fit_subject_to(
    evaluator: Evaluator, subject: np.ndarray, uses: Sequence[Use] = ()
) -> SubjectFit | None:
    """The subject that fits an evaluator's runs best, from a start; None where
    the twin breaks down there.

    At the coarse plant step: misfits are compared, parameters not reported.
    """
    problem = _Held(evaluator, uses)
    z = np.clip(subject / problem.scales, problem.lower, problem.upper)

    def batch(points):
        return problem.batch(points, coarse=True)

    (first,) = batch([z])
    if first is None:
        return None
    solution = solve_gauss_newton(
        batch,
        z,
        problem.lower,
        problem.upper,
        problem.steps,
        problem.radius,
        known=(first, None),
        differentiate=lambda z, r: calc_sensitivities(problem, z, base=r),
        max_iterations=_STEPS,
        tolerance=_END,
    )
    return SubjectFit(
        tuple(evaluator.prepared),
        evaluator,
        solution.z * problem.scales,
        solution.z,
        solution,
        evaluator.noise_level(uses, True),
    )

"""Physical to virtual: the subject's parameters by a MathematicalProgram."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.solvers import (
    IpoptSolver,
    MathematicalProgram,
    NloptSolver,
    SnoptSolver,
    SolverOptions,
)

from brace_drake.core.errors import FitError
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import (
    CandidateFit,
    correct_step,
    finish_fit,
)
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities

# Gauss-Newton steps before the solver, for the scaling of its variables.
_STEPS_TO_SCALE = 4

_SOLVERS = {"snopt": SnoptSolver, "ipopt": IpoptSolver, "nlopt": NloptSolver}


@dataclass(frozen=True)
class SolverReport:
    """How the solver ended."""

    solver: str
    evaluations: int
    cost: float
    success: bool


class _Cost:
    """Half the mean square residual with its gradient, in scaled variables.

    z = z_0 + L^-T w, with L L' the Gauss-Newton Hessian at z_0, a few
    Gauss-Newton steps from the start, makes the Hessian in w near the
    identity, so that a quasi-Newton solver's first step is nearly its last.
    Sensitivities are forward differences of the compiled twin, all runs and
    columns in parallel: the legs, pads and controller are compiled laws that
    AutoDiffXd does not reach. The chain from w to the cost is exact.
    """

    def __init__(self, problem, start, on_evaluation):
        self._problem, self._start = problem, start
        self._on_evaluation = on_evaluation
        self.evaluations = 0
        self.best: tuple[float, np.ndarray, np.ndarray, np.ndarray] | None = (
            None
        )
        residual, jacobian = self._evaluate(start)
        self.count = len(residual)
        hessian = jacobian.T @ jacobian / self.count
        # Of what no run tells, any step is as good.
        hessian[np.diag_indices_from(hessian)] += np.diag(hessian) == 0.0
        ridge = 1e-9 * np.trace(hessian) / len(start)
        factor = np.linalg.cholesky(hessian + ridge * np.eye(len(start)))
        self.z_of_w = np.linalg.inv(factor).T

    def _evaluate(self, z):
        problem = self._problem
        (residual,) = problem.batch([z])
        if residual is None:
            raise FitError("the simulated run broke down during the fit")
        jacobian = calc_sensitivities(problem, z)
        self.evaluations += 1
        cost = float(residual @ residual)
        if self.best is None or cost < self.best[0]:
            self.best = (cost, z.copy(), residual, jacobian)
        if self._on_evaluation:
            self._on_evaluation(self.evaluations, cost / len(residual))
        return residual, jacobian

    def __call__(self, w):
        plain = np.array(
            [v.value() if isinstance(v, AutoDiffXd) else v for v in w],
            dtype=float,
        )
        z = self._start + self.z_of_w @ plain
        z = np.clip(z, self._problem.lower, self._problem.upper)
        residual, jacobian = self._evaluate(z)
        value = 0.5 * float(residual @ residual) / self.count
        if not isinstance(w[0], AutoDiffXd):
            return value
        gradient = self.z_of_w.T @ (jacobian.T @ residual) / self.count
        chain = np.array([v.derivatives() for v in w])
        return AutoDiffXd(value, gradient @ chain)


def fit_subject(
    evaluator: Evaluator,
    start: np.ndarray,
    solver: str = "snopt",
    on_evaluation: Callable[[int, float], None] | None = None,
) -> tuple[CandidateFit, SolverReport]:
    """Fits the subject's parameters to all fit runs jointly.

    Minimises the mean square of the weighted closed-loop residuals within the
    parameters' limits.

    Args:
        evaluator: Over the fit runs.
        start: Values to begin with, inside the limits.
        solver: snopt, ipopt or nlopt.
        on_evaluation: Called with the number of evaluations and the mean
            square residual.

    Raises:
        FitError: Unknown solver, or a run that breaks down.
    """
    if solver not in _SOLVERS:
        raise FitError(f"no solver {solver!r}; there are {', '.join(_SOLVERS)}")
    problem = CandidateProblem(evaluator, ())
    near = solve_gauss_newton(
        problem.batch,
        start / problem.scales,
        problem.lower,
        problem.upper,
        problem.steps,
        problem.radius,
        max_iterations=_STEPS_TO_SCALE,
    )
    z0 = near.z
    cost = _Cost(problem, z0, on_evaluation)
    program = MathematicalProgram()
    w = program.NewContinuousVariables(len(z0), "w")
    program.AddLinearConstraint(
        cost.z_of_w, problem.lower - z0, problem.upper - z0, w
    )
    program.AddCost(cost, w)
    program.SetInitialGuess(w, np.zeros(len(z0)))
    result = _SOLVERS[solver]().Solve(program, None, _options())
    best_cost, z, residual, jacobian = cost.best
    solution = LeastSquaresSolution(
        z,
        residual,
        jacobian,
        cost.evaluations,
        result.is_success(),
    )
    report = SolverReport(
        result.get_solver_id().name(),
        cost.evaluations,
        best_cost / cost.count,
        result.is_success(),
    )
    return correct_step(problem, finish_fit(problem, solution)), report


def _options() -> SolverOptions:
    """Tolerances on a mean square whose noise is 1."""
    options = SolverOptions()
    snopt = SnoptSolver.id()
    options.SetOption(snopt, "Major optimality tolerance", 3e-4)
    options.SetOption(snopt, "Major iterations limit", 30)
    options.SetOption(IpoptSolver.id(), "tol", 1e-5)
    options.SetOption(IpoptSolver.id(), "max_iter", 30)
    options.SetOption(NloptSolver.id(), "algorithm", "LD_SLSQP")
    options.SetOption(NloptSolver.id(), "max_eval", 30)
    return options

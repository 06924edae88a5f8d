"""Rival explanations, each refitted with the subject inside the twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from brace_drake.devices.replays import is_dithered
from brace_drake.devices.stretch import stretch_of
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    calc_triangle,
    solve_gauss_newton,
    step_within,
)
from brace_drake.identification.prior_check import (
    beside_noise,
    looks_scattered,
    shown_spread,
    with_prior,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities

_STEPS, _FAR_STEPS = 10, 30
# Relative decrease of the sum of squares that ends the search at the coarse
# plant step, and at the twin's own.
_NEAR, _END = 1e-3, 1e-5
# Where drives stick the sum of squares is rough: what a search gains by less
# at a time, or in later steps, is chance. Over dozens of parameters the last
# of it is dear, and little beside what any twin is exact to.
_NEAR_ROUGH, _ROUGH_STEPS, _LAST_ROUGH = 1e-2, 8, 1
_MANY, _NEAR_OF_MANY, _END_OF_MANY = 12, 1e-2, 1e-3
# A change of the common spread, or of what is left, by less is none, in
# logarithms.
_SAME_PRIOR = 0.05
_SPREAD_ROUNDS = 3


@dataclass(frozen=True)
class CandidateFit:
    """A candidate after its fit on the fit runs.

    Attributes:
        effects: The effects it adds, none for the nominal twin.
        subject: Values of the subject's parameters.
        values: Parameters of each effect, those of the runs behind.
        solution: The search's end, scaled parameters.
        scales: Of those, so that parameter = z * scale.
        excess: Sum of squares above noise, prior rows left out.
        spread: Fitted standard deviation of many alike parameters, or None.
        num_runs: Runs that it was fitted on.
        num_prior: Rows of the residual that are the prior's.
        refined: Whether the search was led to its end.
        is_dithered: Whether its replays are averages over noise.
        held_out: Misfit on motions that it has not seen, or None.
        stretch: Of numbers known to a tolerance, see `devices.stretch`.
        tolerances: What numbers known to one change: its residual and Jacobian
            are whitened of that.
        is_settled: Whether that is linearised where it stands.
        within: Effects that set those numbers off as the fit has them.
        is_searched: Whether a search has moved it, not screening alone.
        name: Keys of the effects joined by +, or "nominal".
        identifiers, kinds: Their causes, whatever their form, in order and in
            no order.
        uses: The effects with their fitted parameters.
        num_free: Parameters beyond the subject's that were moved.
        is_flexible: Whether one of the effects has dozens of parameters.
        has_run_parameters: Whether single runs have parameters of their own.
    """

    effects: tuple[Effect, ...]
    subject: np.ndarray
    values: tuple[np.ndarray, ...]
    solution: LeastSquaresSolution
    scales: np.ndarray
    excess: float
    spread: float | None
    num_runs: int
    num_prior: int = 0
    refined: bool = False
    is_dithered: bool = False
    held_out: float | None = None
    stretch: float = 0.0
    tolerances: LinearTolerances | None = None
    is_settled: bool = False
    within: tuple[Use, ...] = ()
    is_searched: bool = True
    name: str = field(init=False)
    identifiers: tuple[str, ...] = field(init=False)
    kinds: frozenset[str] = field(init=False)
    uses: tuple[Use, ...] = field(init=False)
    num_free: int = field(init=False)
    is_flexible: bool = field(init=False)
    has_run_parameters: bool = field(init=False)

    def __post_init__(self):
        names = tuple(e.cause for e in self.effects)
        free = len(self.scales) - len(self.subject)
        derived = {
            "name": "+".join(e.key for e in self.effects) or "nominal",
            "identifiers": names,
            "kinds": frozenset(names),
            "uses": tuple(zip(self.effects, self.values, strict=True)),
            "num_free": free,
            "is_flexible": any(e.is_flexible for e in self.effects),
            "has_run_parameters": any(e.run_parameters for e in self.effects),
        }
        vars(self).update(derived)

    @property
    def may_win(self) -> bool:
        """Whether it was led to its end, and its alike parameters are a draw
        from one law.
        """
        return self.refined and self.is_scattered

    @cached_property
    def is_scattered(self) -> bool:
        """Whether its alike parameters may be a sample of their prior."""
        return self.spread is None or looks_scattered(self)


def fit_effects(
    evaluator: Evaluator,
    effects: Sequence[Effect],
    start: CandidateFit | Sequence[np.ndarray],
    is_compared: bool = False,
) -> CandidateFit:
    """Fits effects together with the subject, to the end.

    Args:
        evaluator: Over the fit runs.
        effects: One or more.
        start: A fit of the same effects to go on from, or parameters of each
            effect; then the subject sets out from its nominal values.
        is_compared: Whether it is only held against others: then what the
            plant's step puts into fits of drives that stick stays.
    """
    if isinstance(start, CandidateFit):
        subject, values, spread = start.subject, start.values, start.spread
    else:
        subject = np.array([p.nominal for p in evaluator.twin.subject])
        values, spread = tuple(start), None
    problem = CandidateProblem(evaluator, effects, values, spread)
    z = problem.join(subject, values)
    is_fit = isinstance(start, CandidateFit)
    if not problem.has_spread:
        # Where replays are dithered, what is held against others begins with
        # the sensitivities that it was found with.
        kept = is_fit and is_compared and problem.is_rough
        jacobian = start.solution.jacobian if kept else None
        solution = search(problem, z, jacobian=jacobian)
        return _end(problem, finish_fit(problem, solution), is_compared)
    # Over dozens of parameters a Jacobian costs much; screening left one.
    jacobian, known = start.solution.jacobian if is_fit else None, None
    if is_fit and start.refined:
        problem.weigh_alike(start.excess)
        jacobian = with_prior(problem, start.solution).jacobian
    for _ in range(_SPREAD_ROUNDS):
        solution = search(problem, z, known, jacobian)
        z = solution.z
        # The spread that they show, and what is left; then on from here.
        before = problem.spread, problem.left
        problem.spread = shown_spread(problem, solution)
        rows = solution.residual[: evaluator.ends[-1]]
        excess = evaluator.excess(rows, problem.split(z)[1])
        problem.weigh_alike(excess)
        solution = with_prior(problem, solution)
        known = solution.residual, solution.jacobian
        change = np.log([problem.spread, problem.left]) - np.log(before)
        if np.max(np.abs(change)) < _SAME_PRIOR:
            break
    return _end(problem, finish_fit(problem, solution), is_compared)


def _end(
    problem: CandidateProblem, fit: CandidateFit, is_compared: bool
) -> CandidateFit:
    if problem.is_rough and is_compared:
        return beside_noise(problem, replace(fit, refined=True))
    return correct_step(problem, fit)


def correct_fit(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """A fit of drives that stick as `correct_step` leaves it."""
    problem = CandidateProblem(evaluator, fit.effects, fit.values, fit.spread)
    return correct_step(problem, fit) if problem.is_rough else fit


def search(
    problem: CandidateProblem,
    z: np.ndarray,
    known: tuple[np.ndarray, np.ndarray] | None = None,
    jacobian: np.ndarray | None = None,
) -> LeastSquaresSolution:
    """Gauss-Newton from z to the end: first at the coarse plant step, from
    there at the twin's own, with the sensitivities of the coarse one.

    Args:
        problem: Of the candidate.
        z: Where it begins.
        known: Residual at the twin's own step and Jacobian, where the coarse
            part was done before.
        jacobian: For the coarse part to begin with.
    """
    limits = problem.lower, problem.upper, problem.steps, problem.radius
    is_dear = problem.num_free > _MANY
    if known is None:
        rough = problem.is_rough
        tolerance = _NEAR_OF_MANY if is_dear else _NEAR
        batch = partial(problem.batch, coarse=True)
        near = solve_gauss_newton(
            batch,
            z,
            *limits,
            known=(batch([z])[0], jacobian),
            differentiate=lambda z, r: calc_sensitivities(problem, z, base=r),
            max_iterations=_ROUGH_STEPS if rough else _FAR_STEPS,
            tolerance=_NEAR_ROUGH if rough else tolerance,
        )
        z = near.z
        known = problem.batch([z])[0], near.jacobian
    return solve_gauss_newton(
        problem.batch,
        z,
        *limits,
        differentiate=lambda z, residual: known[1],
        known=known,
        max_iterations=_LAST_ROUGH if problem.is_rough else _STEPS,
        tolerance=_END_OF_MANY if is_dear else _END,
    )


def correct_step(problem: CandidateProblem, fit: CandidateFit) -> CandidateFit:
    """Takes off a fit what the plant's step has put into its parameters.

    One Gauss-Newton step on residuals at half the plant step, with the
    sensitivities at hand: mass and damping move by about their standard
    errors, at a small part of the cost of a fit at that step.
    """
    solution = fit.solution
    if problem.has_spread:
        problem.weigh_alike(fit.excess)
        solution = with_prior(problem, solution)
    (residual,) = problem.batch([solution.z], fine=True)
    if residual is None:
        return beside_noise(problem, replace(fit, refined=True))
    triangle = calc_triangle([solution.jacobian, residual])
    limits = problem.lower, problem.upper, problem.radius
    step = step_within(triangle, solution.z, limits)
    (moved,) = problem.batch([solution.z + step], fine=True)
    if moved is not None and moved @ moved <= residual @ residual:
        corrected = replace(solution, z=solution.z + step, residual=moved)
        fit = finish_fit(problem, corrected)
    return beside_noise(problem, replace(fit, refined=True))


def finish_fit(
    problem: CandidateProblem,
    solution: LeastSquaresSolution,
    coarse: bool = False,
    is_searched: bool = True,
) -> CandidateFit:
    """The fit that a search has ended with; `coarse` as it was evaluated."""
    evaluator = problem.evaluator
    rows = len(solution.residual) - problem.num_prior
    residual = solution.residual[:rows]
    subject, uses = problem.split(solution.z)
    excess = evaluator.excess(residual, uses, coarse)
    known, spread = problem.tolerances, None
    stretch = 0.0 if known is None else stretch_of(known, residual)
    if problem.has_spread:
        spread = problem.spread * problem.spread_scale
    return CandidateFit(
        problem.effects,
        subject,
        tuple(v for _, v in uses),
        solution,
        problem.scales,
        excess,
        spread,
        len(evaluator.prepared),
        problem.num_prior,
        is_dithered=is_dithered(evaluator.twin, uses),
        stretch=stretch,
        tolerances=known,
        is_searched=is_searched,
    )

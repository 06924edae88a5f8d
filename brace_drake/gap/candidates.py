"""Rival explanations, each refitted with the subject inside the twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.fit.gauss_newton import (
    LeastSquaresSolution,
    bounded_step,
    solve_gauss_newton,
)
from brace_drake.gap.evaluation import Evaluator

_SUBJECT_STEP, _SUBJECT_RADIUS = 1e-3, 0.3
# Spread at which a search over many alike parameters begins.
_FIRST_SPREAD = 2.0
_SCREENING_STEPS = 4
_STEPS = 10
# Effects with more parameters than this are screened with one Jacobian.
_FEW = 4


@dataclass(frozen=True)
class CandidateFit:
    """A candidate after its fit on the fit runs.

    Attributes:
        effects: The effects it adds, none for the nominal twin.
        subject: Values of the subject's parameters.
        values: Parameter vector of each effect.
        solution: The search's end, scaled parameters.
        scales: Of those, so that parameter = z * scale.
        excess: Sum of squares above noise, prior rows left out.
        spread: Fitted standard deviation of many alike parameters, or None.
        excess_by_run: The excess of each fit run.
    """

    effects: tuple[Effect, ...]
    subject: np.ndarray
    values: tuple[np.ndarray, ...]
    solution: LeastSquaresSolution
    scales: np.ndarray
    excess: float
    spread: float | None
    excess_by_run: np.ndarray

    @property
    def name(self) -> str:
        """Names of the effects joined by +, or "nominal"."""
        return "+".join(e.name for e in self.effects) or "nominal"

    @property
    def uses(self) -> tuple[Use, ...]:
        """The effects with their fitted parameters."""
        return tuple(zip(self.effects, self.values, strict=True))


class CandidateProblem:
    """Scaled parameters of subject and effects, and the residual of them.

    z holds the subject's parameters in units of their nominal values, then
    each effect's in units of its starts or limits; effects with a common
    spread add a row z_i / spread for every parameter, the normal prior.
    """

    def __init__(self, evaluator: Evaluator, effects: Sequence[Effect]):
        self.evaluator = evaluator
        self.effects = tuple(effects)
        subject = evaluator.twin.subject
        self.num_subject = len(subject)
        units = [p.unit_step for p in subject]
        low = [p.lower for p in subject]
        high = [p.upper for p in subject]
        self.spread = _FIRST_SPREAD
        self._prior = []
        for effect in effects:
            for p in effect.parameters:
                self._prior.append(effect.spread is not None)
                units.append(_scale_of(p))
                low.append(p.lower)
                high.append(p.upper)
        self.scales = np.array(units)
        self.lower = np.array(low) / self.scales
        self.upper = np.array(high) / self.scales
        self._has_prior = np.array(
            [False] * self.num_subject + self._prior, dtype=bool
        )

    def split(self, z: np.ndarray) -> tuple[np.ndarray, tuple[Use, ...]]:
        """Subject values and effect uses of scaled parameters."""
        values = z * self.scales
        uses, at = [], self.num_subject
        for effect in self.effects:
            size = len(effect.parameters)
            uses.append((effect, values[at : at + size]))
            at += size
        return values[: self.num_subject], tuple(uses)

    def batch(
        self,
        points: Sequence[np.ndarray],
        coarse: bool = False,
        fine: bool = False,
    ) -> list[np.ndarray | None]:
        """Weighted residuals with the prior's rows below."""
        found = self.evaluator.residuals(
            [self.split(z) for z in points], coarse, fine
        )
        if not self._has_prior.any():
            return found
        return [
            None
            if r is None
            else np.concatenate([r, z[self._has_prior] / self.spread])
            for r, z in zip(found, points, strict=True)
        ]

    @property
    def num_prior(self) -> int:
        """Rows that the prior adds."""
        return int(self._has_prior.sum())

    @property
    def prior_scale(self) -> float:
        """Scale of the parameters that have a common spread."""
        return float(self.scales[self._has_prior][0])

    def steps(self) -> np.ndarray:
        """Steps of the finite differences."""
        free = len(self.scales) - self.num_subject
        return np.concatenate(
            [np.full(self.num_subject, _SUBJECT_STEP), np.full(free, 1e-2)]
        )

    def radius(self) -> np.ndarray:
        """Largest step of one iteration."""
        free = len(self.scales) - self.num_subject
        return np.concatenate(
            [np.full(self.num_subject, _SUBJECT_RADIUS), np.full(free, 5.0)]
        )


def _scale_of(parameter) -> float:
    start = abs(parameter.starts[len(parameter.starts) // 2])
    return start if start > 0.0 else 0.05 * parameter.upper


def fit_nominal(evaluator: Evaluator) -> CandidateFit:
    """Fits the subject's parameters alone."""
    problem = CandidateProblem(evaluator, ())
    nominal = np.array([p.nominal for p in evaluator.twin.subject])
    solution = solve_gauss_newton(
        problem.batch,
        nominal / problem.scales,
        problem.lower,
        problem.upper,
        problem.steps(),
        problem.radius(),
    )
    return correct_step(problem, finish_fit(problem, solution))


def fit_effects(
    evaluator: Evaluator,
    effects: Sequence[Effect],
    nominal: CandidateFit,
    start: CandidateFit | None = None,
    leader: CandidateFit | None = None,
    thorough: bool = True,
) -> CandidateFit:
    """Fits effects together with the subject.

    Args:
        evaluator: Over the fit runs.
        effects: One or more.
        nominal: The nominal fit; the Jacobian of its first step, at nominal
            values, is what the search sets out with.
        start: A fit of the same effects to go on from; otherwise the search
            sets out from the subject's nominal values, not from those that
            have absorbed what the effects explain, and from all starts on the
            cards.
        leader: A fit of the first effects, from whose values the search sets
            out while the last effect takes its starts.
        thorough: To the end; otherwise a few steps, with the subject's
            columns kept, to see who is worth it.
    """
    if start is not None:
        z = np.concatenate([start.subject, *start.values])
        return _search(evaluator, effects, nominal, z, start.spread, thorough)
    if leader is not None:
        first = np.concatenate([leader.subject, *leader.values])
    else:
        first = np.array([p.nominal for p in evaluator.twin.subject])
    best = None
    for last in effects[-1].starts():
        z = np.concatenate([first, last])
        fit = _search(evaluator, effects, nominal, z, None, thorough)
        if best is None or fit.excess < best.excess:
            best = fit
    return best


def _search(
    evaluator, effects, nominal, start, spread, thorough
) -> CandidateFit:
    problem = CandidateProblem(evaluator, effects)
    n = problem.num_subject
    if spread is not None and problem.num_prior:
        problem.spread = spread / problem.prior_scale
    z = start / problem.scales
    rows = nominal.solution.first_jacobian[:, :n]
    known = np.vstack([rows, np.zeros((problem.num_prior, n))])
    rounds = 2 if thorough and problem.num_prior else 1
    batch = problem.batch if thorough else partial(problem.batch, coarse=True)
    for _ in range(rounds):
        solution = solve_gauss_newton(
            batch,
            z,
            problem.lower,
            problem.upper,
            problem.steps(),
            problem.radius(),
            known=None if thorough else known,
            refresh=None if thorough else range(n, len(z)),
            renew=thorough or len(z) - n <= _FEW,
            max_iterations=_STEPS if thorough else _SCREENING_STEPS,
        )
        z = solution.z
        if not problem.num_prior:
            break
        # The spread that the evidence prefers; then search again from here.
        change = np.log(_evidence_spread(problem, solution) / problem.spread)
        problem.spread *= np.exp(change)
        if abs(change) < 0.05:
            break
    fit = finish_fit(problem, solution, coarse=not thorough)
    return correct_step(problem, fit) if thorough else fit


def correct_step(problem: CandidateProblem, fit: CandidateFit) -> CandidateFit:
    """Takes off a fit what the plant's step has put into its parameters.

    One Gauss-Newton step on residuals at half the plant step, with the
    sensitivities at hand: mass and damping move by about their standard
    errors, at a small part of the cost of a fit at that step.
    """
    solution = fit.solution
    (residual,) = problem.batch([solution.z], fine=True)
    step = bounded_step(
        solution.jacobian,
        residual,
        solution.z,
        problem.lower,
        problem.upper,
        problem.radius(),
    )
    (moved,) = problem.batch([solution.z + step], fine=True)
    if moved is None or moved @ moved > residual @ residual:
        return fit
    corrected = replace(solution, z=solution.z + step, residual=moved)
    return finish_fit(problem, corrected)


def _evidence_spread(problem, solution) -> float:
    """Fixed point of the evidence: s^2 = mean of z_i^2 + var z_i."""
    triangle = np.linalg.qr(solution.jacobian, mode="r")
    inverse = np.linalg.pinv(triangle)
    variance = np.sum(inverse**2, axis=1)
    prior = problem._has_prior
    return float(np.sqrt(np.mean(solution.z[prior] ** 2 + variance[prior])))


def finish_fit(
    problem: CandidateProblem,
    solution: LeastSquaresSolution,
    coarse: bool = False,
) -> CandidateFit:
    """The fit that a search has ended with; `coarse` as it was evaluated."""
    evaluator = problem.evaluator
    rows = len(solution.residual) - problem.num_prior
    residual = solution.residual[:rows]
    subject, uses = problem.split(solution.z)
    ends = np.cumsum([p.num_weighted for p in evaluator.prepared])
    level = evaluator.noise_level(uses, coarse)
    excess_by_run = np.array(
        [
            part @ part - level * prepared.count
            for part, prepared in zip(
                np.split(residual, ends[:-1]), evaluator.prepared, strict=True
            )
        ]
    )
    spread = None
    if problem.num_prior:
        spread = problem.spread * problem.prior_scale
    return CandidateFit(
        problem.effects,
        subject,
        tuple(v for _, v in uses),
        replace(solution, residual=residual),
        problem.scales,
        float(excess_by_run.sum()),
        spread,
        excess_by_run,
    )

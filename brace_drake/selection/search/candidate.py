"""A candidate explanation on its way: where its search stands, and its steps.

Everything is simulated at the coarse plant step. Sensitivities of the subject,
and of effects that are there already, are kept from the fit that the search
sets out from, unless told otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.fits import CandidateFit, finish_fit
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.run_starts import best_run_starts
from brace_drake.identification.sensitivities import calc_sensitivities
from brace_drake.selection import thresholds
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.tolerated import left_by


@dataclass
class Candidate:
    """Where the search of a candidate stands, and what is predicted of it.

    Attributes:
        problem: Its parameters.
        z: Where it stands.
        residual: There, prior rows below.
        jacobian: Of its last step; None before it was searched, or where what
            goes on from it makes its own.
        predicted: Excess, strained, that it is predicted to leave.
        start: Where parameters of several starts began.
        others: The same effect from another start, best first.
        is_searched: Whether steps were taken.
        added: The effect that it has beside those of the base.
        name: Keys of its effects, joined by +.
    """

    problem: CandidateProblem
    z: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray | None = None
    predicted: float = np.inf
    start: tuple[float, ...] = ()
    others: tuple[Candidate, ...] = ()
    is_searched: bool = False

    def __post_init__(self):
        effects = self.problem.effects
        self.added = effects[-1]
        self.name = "+".join(e.key for e in effects)

    @property
    def excess(self) -> float:
        """Sum of squares above noise where it stands, searched or not,
        strained.
        """
        return left_by(self._stand(), self.problem.evaluator.count)

    @property
    def left(self) -> float:
        """The same; not yet searched, as predicted."""
        return self.excess if self.is_searched else self.predicted

    def fit(self) -> CandidateFit:
        """Where it stands as a fit; not yet searched, as predicted."""
        fit = self._stand()
        if self.is_searched:
            return fit
        return replace(fit, excess=float(self.predicted), stretch=0.0)

    def _stand(self) -> CandidateFit:
        solution = LeastSquaresSolution(
            self.z, self.residual, self.jacobian, 0, False
        )
        return finish_fit(
            self.problem, solution, coarse=True, is_searched=self.is_searched
        )

    def forget_jacobian(self) -> None:
        """Drops it where what goes on from here makes its own: those of all
        candidates would fill the memory.
        """
        if not (self.problem.is_rough or self.problem.has_spread):
            self.jacobian = None

    def step(self, base: Linearisation, count: int, own: bool = False) -> bool:
        """Takes Gauss-Newton steps; False where the twin breaks down.

        Sensitivities of the base's parameters are kept from it, or are `own`
        ones of where the search is, as an effect of dozens of parameters
        always has: it goes far from the base.
        """
        problem = self.problem
        always = self.added.spread is not None
        differentiate = partial(base.differentiate, problem)
        if own or always:
            differentiate = partial(_differentiate, problem)
        is_rough = problem.is_rough or problem.has_spread
        many = problem.num_free > thresholds.FEW
        kept = self.jacobian if many and (always or not own) else None
        try:
            solution = solve_gauss_newton(
                partial(problem.batch, coarse=True),
                self.z,
                problem.lower,
                problem.upper,
                problem.steps,
                problem.radius,
                differentiate=differentiate,
                known=(self.residual, kept),
                max_iterations=count,
                tolerance=thresholds.END_ROUGH if is_rough else thresholds.END,
                first=problem.num_subject,
            )
        except (BraceError, ValueError, np.linalg.LinAlgError):
            return False
        self.z, self.residual = solution.z, solution.residual
        self.jacobian, self.is_searched = solution.jacobian, True
        return True


def _differentiate(problem: CandidateProblem, z, residual):
    return calc_sensitivities(problem, z, base=residual)


def with_one_more(
    base: Linearisation, effect: Effect, values: np.ndarray
) -> Candidate | None:
    """The base with one more effect where its search begins; None where its
    twin breaks down. Runs take the best of the effect's own starts.

    Args:
        base: Where the search sets out from.
        effect: The one more.
        values: Its parameters.
    """
    fit = base.base
    return make_candidate(
        base,
        [*fit.effects, effect],
        [*fit.values, values],
        fit.subject,
        fit.spread,
        effect,
    )


def make_candidate(
    base: Linearisation,
    effects: Sequence[Effect],
    values: Sequence[np.ndarray],
    subject: np.ndarray,
    spread: float | None = None,
    fresh: Effect | None = None,
) -> Candidate | None:
    """A candidate where its search begins; None where its twin breaks down.

    Args:
        base: Where the search sets out from.
        effects: Of the candidate, the base's first.
        values: Parameters of each.
        subject: Values of the subject's parameters.
        spread: Of parameters that have a common one, where it is known; of
            no account where none of the effects has any.
        fresh: An effect whose runs take the best of their own starts.
    """
    problem = CandidateProblem(base.evaluator, effects, values, spread)
    z = problem.join(subject, values)
    if fresh is not None:
        z, residual = best_run_starts(problem, z, fresh)
    else:
        (residual,) = problem.batch([z], coarse=True)
    return None if residual is None else Candidate(problem, z, residual)


def candidate_of(
    base: Linearisation,
    uses: Sequence[Use],
    subject: np.ndarray,
    spread: float | None = None,
) -> Candidate | None:
    """The same of effects with their parameters, one at least.

    Args:
        base, subject, spread: See `make_candidate`.
        uses: Of the candidate.
    """
    effects, values = zip(*uses, strict=True)
    return make_candidate(base, effects, values, subject, spread)


def best_of_starts(
    base: Linearisation, candidates: Sequence[Candidate]
) -> Candidate | None:
    """The one that leaves least after a round of steps, led on while that
    brings much: what begins best often comes to a stop first. None where no
    twin runs.

    Args:
        base: Where they set out from.
        candidates: The same effects from several starts.
    """
    steps = [
        partial(c.step, base, thresholds.NESTED_STEPS, own=True)
        for c in candidates
    ]
    went = base.evaluator.together(steps)
    able = [c for c, well in zip(candidates, went, strict=True) if well]
    best = min(able, key=lambda c: c.excess, default=None)
    if best is None:
        return None
    for _ in range(thresholds.NESTED_ROUNDS - 1):
        before = best.excess
        if not best.step(base, thresholds.NESTED_STEPS, own=True):
            break
        if best.excess > thresholds.NESTED_WORTH * before:
            break
    return best

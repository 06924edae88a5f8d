"""Dry friction beside what shows on imposed motion, where nothing sticks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import (
    CandidateFit,
    finish_fit,
    fit_effects,
)
from brace_drake.identification.least_squares import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.nested import richer_starts
from brace_drake.selection.search.screening import Say


def fit_frictions(
    evaluator: Evaluator,
    frictions: Sequence[CandidateFit],
    imposed: CandidateFit,
    effects: Sequence[Effect],
    say: Say,
) -> list[CandidateFit]:
    """Frictions beside the subject and the effect, if any, that show on
    imposed motion; refined, and of the same effects several.

    Those are kept as they are there: in closed loop chance would move them.

    Args:
        evaluator: Over the fit runs, in closed loop.
        frictions: As they are alone.
        imposed: Fit on imposed motion.
        effects: Frictions that may be richer.
        say: Progress, shares of this search.
    """
    found = []
    for place, friction in enumerate(frictions):
        say(f"cause {friction.name}", place / len(frictions))
        for effect, starts in _starts(friction, effects):
            fit = _fit_friction(evaluator, effect, starts, imposed)
            if fit is not None:
                found.append(fit)
    return found


def fit_alone(
    evaluator: Evaluator, imposed: CandidateFit
) -> CandidateFit | None:
    """In closed loop the effect that shows on imposed motion, without
    friction; None where its twin breaks down.
    """
    try:
        return fit_effects(evaluator, imposed.effects, imposed)
    except (BraceError, ValueError):
        return None


def is_settled(
    criterion: Criterion,
    pairs: Sequence[CandidateFit],
    alone: CandidateFit | None,
) -> bool:
    """Whether friction and the effect that shows on imposed motion explain the
    gap, and by far less is left than without friction.
    """
    most = np.inf
    if alone is not None:
        most = thresholds.FRICTION_SHARE * max(0.0, alone.excess)
    return any(f.excess < most and criterion.explains(f) for f in pairs)


def _starts(
    friction: CandidateFit, effects: Sequence[Effect]
) -> Iterator[tuple[Effect, list[np.ndarray]]]:
    """The friction from where it is, and richer ones from near there."""
    (effect, values), *_ = friction.uses
    yield effect, [values]
    for richer in effects:
        if richer.is_richer_than(effect):
            yield richer, list(richer_starts(richer, effect, values))


def _fit_friction(
    evaluator: Evaluator,
    effect: Effect,
    starts: Sequence[np.ndarray],
    imposed: CandidateFit,
) -> CandidateFit | None:
    known = list(imposed.values)
    problem = CandidateProblem(
        evaluator, [*imposed.effects, effect], [*known, starts[0]]
    )
    points = [problem.join(imposed.subject, [*known, s]) for s in starts]
    kept = len(problem.scales) - int(effect.is_continuous.sum())
    try:
        return _search(problem, points, kept)
    except (BraceError, ValueError):
        return None


def _search(
    problem: CandidateProblem, points: Sequence[np.ndarray], kept: int
) -> CandidateFit:
    """From the best of points, with the first so many parameters kept."""
    coarse = partial(problem.batch, coarse=True)

    def differentiate(z, residual):
        out = np.zeros((len(residual), len(z)))
        out[:, kept:] = problem.columns(z, kept, residual)
        return out

    found = [(r @ r, i) for i, r in enumerate(coarse(points)) if r is not None]
    z = points[min(found)[1]]
    limits = problem.lower, problem.upper, problem.steps, problem.radius
    for batch, count in (
        (coarse, thresholds.FRICTION_STEPS),
        (problem.batch, thresholds.FRICTION_LAST_STEPS),
    ):
        solution = solve_gauss_newton(
            batch,
            z,
            *limits,
            differentiate=differentiate,
            max_iterations=count,
            tolerance=thresholds.FRICTION_END,
        )
        z = solution.z
    (there,) = coarse([z])
    if there is None:
        raise ValueError("the twin breaks down at the coarse plant step")
    whole = LeastSquaresSolution(
        z, solution.residual, problem.columns(z, base=there), 0, True
    )
    return replace(finish_fit(problem, whole), refined=True)

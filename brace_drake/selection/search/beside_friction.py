"""Friction with what shows on the contact's side, where nothing sticks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator, sticks
from brace_drake.identification.fits import (
    CandidateFit,
    finish_fit,
    fit_effects,
)
from brace_drake.identification.gauss_newton import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection.decision import explains
from brace_drake.selection.null_bootstrap import NullDistribution
from brace_drake.selection.search.nested import richer_starts

# Frictions that are set beside it.
_FRICTIONS = 2
# Of what the best leaves: one that leaves more is no rival of it.
_NEAR = 2.0
# Share of what the effect of the contact's side leaves alone, at most, that it
# leaves with a friction that is there.
_BY_FAR = 0.25
# Steps of a friction's search, first and last; decrease that ends it, in
# relative terms: less is chance.
_STEPS, _LAST_STEPS, _END = 8, 3, 1e-2


def sticking(
    evaluator: Evaluator, fits: Sequence[CandidateFit], limit: float
) -> list[CandidateFit]:
    """Single effects with which drives stick, if they are among the best and
    none of those explains all that there is.

    Args:
        evaluator: Over the fit runs.
        fits: Of single effects.
        limit: Mean square, in floors, up to which one does.
    """
    known = [f for f in fits if f.is_searched]
    least = min((max(0.0, f.excess) for f in known), default=np.inf)
    if least <= limit * evaluator.count:
        return []
    near = [f for f in known if f.excess <= _NEAR * least]
    near = [f for f in near if sticks(evaluator.twin, f.uses)]
    return sorted(near, key=lambda f: f.excess)[:_FRICTIONS]


def fit_frictions(
    evaluator: Evaluator,
    frictions: Sequence[CandidateFit],
    side: CandidateFit,
    cards: Sequence[Effect],
    say: Callable[[str, float], None],
) -> list[CandidateFit]:
    """Frictions beside the subject that the contact's side has, and the effect
    that it shows, if it shows one; refined, and of the same effects several.

    Those are kept as they are there: in closed loop chance would move them.

    Args:
        evaluator: Over the fit runs, in closed loop.
        frictions: As they are alone.
        side: Fit of the contact's side alone.
        cards: Frictions that may be richer.
        say: Progress, shares of this search.
    """
    found = []
    for place, friction in enumerate(frictions):
        say(f"cause {friction.name}", place / len(frictions))
        for effect, starts in _starts(friction, cards):
            fit = _fit_friction(evaluator, effect, starts, side)
            if fit is not None:
                found.append(fit)
    return found


def fit_alone(evaluator: Evaluator, side: CandidateFit) -> CandidateFit | None:
    """In closed loop the effect of the contact's side without friction; None
    where its twin breaks down.
    """
    try:
        return fit_effects(evaluator, side.effects, side)
    except (BraceError, ValueError):
        return None


def is_settled(
    evaluator: Evaluator,
    nominal: CandidateFit,
    pairs: Sequence[CandidateFit],
    alone: CandidateFit | None,
    null: NullDistribution,
) -> bool:
    """Whether friction and the effect of the contact's side explain the gap,
    and by far less is left than without friction.
    """
    most = np.inf if alone is None else _BY_FAR * max(0.0, alone.excess)
    return any(
        f.excess < most and explains(evaluator, nominal, f, null) for f in pairs
    )


def _starts(
    friction: CandidateFit, cards: Sequence[Effect]
) -> Iterator[tuple[Effect, list[np.ndarray]]]:
    """The friction from where it is, and richer ones from near there."""
    (effect, values), *_ = friction.uses
    yield effect, [values]
    for card in cards:
        if card.is_richer_than(effect):
            yield card, list(richer_starts(card, effect, values))


def _fit_friction(
    evaluator: Evaluator,
    effect: Effect,
    starts: Sequence[np.ndarray],
    side: CandidateFit,
) -> CandidateFit | None:
    problem = CandidateProblem(
        evaluator, [*side.effects, effect], [*side.values, starts[0]]
    )
    points = [problem.join(side.subject, [*side.values, s]) for s in starts]
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
    for batch, count in ((coarse, _STEPS), (problem.batch, _LAST_STEPS)):
        solution = solve_gauss_newton(
            batch,
            z,
            *limits,
            differentiate=differentiate,
            max_iterations=count,
            tolerance=_END,
        )
        z = solution.z
    (there,) = coarse([z])
    if there is None:
        raise ValueError("the twin breaks down at the coarse plant step")
    whole = LeastSquaresSolution(
        z, solution.residual, problem.columns(z, base=there), 0, True
    )
    return replace(finish_fit(problem, whole), refined=True)

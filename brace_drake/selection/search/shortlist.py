"""Who is a contender after a race, and the end of his search."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_effects
from brace_drake.selection.decision import refined
from brace_drake.selection.measures import is_exact
from brace_drake.selection.search.candidate import Runner, make_runner, step
from brace_drake.selection.search.linearisation import Ground

# A rival that leaves this many times what the leader leaves is out.
_CONTENDER = 1.5
_MAX_CONTENDERS = 3
# Other values of discrete parameters that are searched for the best, and how
# far.
_OTHERS, _STEPS = 2, 4
# Who leaves more than this share of what there was has gained nothing.
_NO_GAIN = 0.9
# Of the floor's mean square: about as near as a coarse search comes.
_COARSE = 0.03


def best_fits(runners: Sequence[Runner]) -> list[CandidateFit]:
    """One fit for each candidate, best first."""
    fits = sorted((r.fit() for r in runners), key=lambda f: f.excess)
    searched = {f.name for f in fits if f.is_searched}
    best: dict[str, CandidateFit] = {}
    for fit in fits:
        if fit.name not in searched or fit.is_searched:
            best.setdefault(fit.name, fit)
    return list(best.values())


def best_of_each(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Refined fits, of the same effects the best one."""
    best: dict[frozenset[str], CandidateFit] = {}
    for fit in refined(fits):
        best.setdefault(frozenset(e.key for e in fit.effects), fit)
    return list(best.values())


def refine(
    evaluator: Evaluator,
    fits: Sequence[CandidateFit],
    there: float,
    most: float = np.inf,
    rivals: float = np.inf,
) -> list[CandidateFit]:
    """Leads the search of the contenders to its end, best first.

    Args:
        evaluator: Over the fit runs.
        fits: From a race.
        there: Excess of the fit that the race set out from; who takes next to
            nothing of it is no contender, unless he is the best.
        most: Who leaves more excess is none, be he the best.
        rivals: Nor is, beside the best, who leaves more than this.
    """
    out = []
    ranked = sorted(fits, key=lambda f: f.excess)
    # Rivals are compared as the race has left them, all alike unfinished.
    bar = (
        _bar(ranked[0].excess, there, _COARSE * evaluator.count) if fits else 0
    )
    for place, fit in enumerate(ranked):
        searched = fit.is_searched and not fit.refined
        if place < _MAX_CONTENDERS and searched and fit.excess <= most:
            if place == 0 or fit.excess <= min(bar, rivals):
                fit = try_refine(evaluator, fit)
        out.append(fit)
    return out


def _bar(least: float, there: float, trust: float) -> float:
    """Excess up to which a fit is a contender."""
    return min(_NO_GAIN * there - trust, _CONTENDER * max(trust, least + trust))


def other_choices(ground: Ground, fit: CandidateFit) -> list[Runner]:
    """The fit with its last effect's discrete parameters at other values."""
    card, found = fit.effects[-1], []
    mine = fit.values[-1][: len(card.parameters)]
    discrete = [p.choices for p in card.parameters if p.choices]
    for choice in itertools.product(*discrete):
        values = mine.copy()
        values[~card.is_continuous] = choice
        if np.array_equal(values, mine):
            continue
        runner = make_runner(
            ground, fit.effects, [*fit.values[:-1], values], fit.subject
        )
        if runner is not None:
            found.append(runner)
    found.sort(key=lambda r: r.residual @ r.residual)
    for runner in found[:_OTHERS]:
        step(ground, runner, _STEPS)
    return found[:_OTHERS]


def polish(
    ground: Ground, fits: list[CandidateFit], most: float
) -> list[CandidateFit]:
    """Tries other discrete parameters of the best fit, where it has any and
    leaves at most so much excess.
    """
    best = next(iter(refined(fits)), None)
    if best is None or best.excess > most:
        return fits
    if best.effects[-1].is_flexible or is_exact(ground.evaluator, best):
        return fits
    for runner in other_choices(ground, best):
        other = runner.fit()
        if other.is_searched and other.excess < best.excess:
            other = try_refine(ground.evaluator, other)
        if other.refined and other.excess < best.excess:
            fits = [other if f is best else f for f in fits]
            best = other
    return fits


def try_refine(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """Leads a search to its end; the fit as it is where its twin breaks."""
    try:
        return fit_effects(evaluator, fit.effects, fit)
    except (BraceError, ValueError):
        # A candidate whose twin cannot even run explains nothing.
        return fit

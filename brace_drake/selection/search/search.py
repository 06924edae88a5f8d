"""The search for causes: forward and backward over sets of effects.

From the nominal twin, then from the best sets so far, every further effect is
screened by a linearised replay, the most promising ones are searched and the
best led to their end; a set is also tried without each of its effects. It ends
where the criterion says that one effect more does not pay, or that nothing is
left (stepwise selection with a beam; Hastie, Tibshirani, Friedman, The Elements
of Statistical Learning, section 3.3).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import effects_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, best_of_kinds, refined
from brace_drake.selection.level import with_level
from brace_drake.selection.search.candidate import make_candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.nested import search_richer
from brace_drake.selection.search.screening import (
    Say,
    others,
    screen,
    search_best,
)
from brace_drake.selection.search.shortlist import (
    best_fits,
    improve_choices,
    refine,
    try_refine,
)
from brace_drake.selection.search.stretched import fit_stretched
from brace_drake.selection.search.within import refit_within, set_out


def search_causes(
    evaluator: Evaluator, criterion: Criterion, say: Say
) -> list[CandidateFit]:
    """Fits of all single effects and of the sets that they lead to.

    Args:
        evaluator: Over the fit runs.
        criterion: With the nominal fit.
        say: Progress.
    """
    effects = list(effects_for(evaluator.twin.device).values())
    known = _stretched(evaluator, criterion, criterion.nominal, effects)
    ranked = best_of_kinds(criterion, [criterion.nominal, *known])
    # Friction within its tolerance is no effect: the search sets out from it.
    base = next(f for f in ranked if not criterion.findings(f))
    criterion = with_level(evaluator, criterion, ranked[0])
    room = MAX_EFFECTS - len(evaluator.twin.carried) - len(base.effects)
    if not criterion.is_beyond_level(ranked[0]):
        room = min(room, 1)
    beam = [base]
    for number in range(1, min(room, thresholds.MOST_EFFECTS) + 1):
        part = _part(say, number)
        for base in beam:
            set_out(evaluator, base)
            if number > 1:
                base = refit_within(evaluator, base, criterion.nuisances)
                known.append(base)
                known += _stretched(evaluator, criterion, base, effects)
            known += _forward(evaluator, criterion, base, effects, part)
        if number > 1:
            known += _backward(evaluator, criterion, known, number)
        ranked = best_of_kinds(criterion, [criterion.nominal, *known])
        best = ranked[0]
        # Friction that is found within its tolerance adds to the level.
        criterion = with_level(evaluator, criterion, best)
        is_shorter = len(criterion.findings(best)) < number
        if not criterion.is_beyond_level(best) or (number > 1 and is_shorter):
            break
        beam = _beam(criterion, ranked, number)
    return known


def _beam(
    criterion: Criterion, ranked: Sequence[CandidateFit], number: int
) -> list[CandidateFit]:
    """The best sets of a number of effects, of which larger ones are made; of
    effects by the dozen none: they cover what others do.
    """
    able = [
        f
        for f in ranked
        if len(criterion.findings(f)) == number and not f.is_flexible
    ]
    able.sort(key=lambda f: f.excess)
    if not able:
        return []
    near = [f for f in able if f.excess <= thresholds.NEAR * able[0].excess]
    return near[: thresholds.BEAM if number == 1 else 1]


def _forward(
    evaluator: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    effects: Sequence[Effect],
    say: Say,
) -> list[CandidateFit]:
    """A set with one more effect: first those of few parameters, and those of
    dozens where these leave something.
    """
    try:
        lines = Linearisation(evaluator, base)
    except BraceError:
        return []
    found: list[CandidateFit] = []
    for flexible in (False, True):
        more = others(effects, base, flexible)
        candidates = screen(lines, more, say)
        places = thresholds.PLACES if not flexible else len(more)
        search_best(lines, candidates, say, places=places)
        candidates += search_richer(lines, candidates, more)
        fits = refine(evaluator, best_fits(candidates), base.excess)
        fits = improve_choices(lines, fits, np.inf)
        found += fits
        best = next(iter(refined(found)), base)
        if not criterion.is_beyond_level(best):
            break
    return found


def _backward(
    evaluator: Evaluator,
    criterion: Criterion,
    known: Sequence[CandidateFit],
    number: int,
) -> list[CandidateFit]:
    """The best set without each of its effects, where that was not led to its
    end before.
    """
    ranked = best_of_kinds(criterion, known)
    best = next(
        (f for f in ranked if len(criterion.findings(f)) == number), None
    )
    if best is None:
        return []
    done, found = {f.kinds for f in ranked}, []
    set_out(evaluator, best)
    lines = Linearisation(evaluator, criterion.nominal)
    for out in best.effects:
        kept = [u for u in best.uses if u[0] is not out]
        if {e.name for e, _ in kept} in done or not kept:
            continue
        parts, values = zip(*kept, strict=True)
        less = make_candidate(lines, parts, values, best.subject, best.spread)
        if less is not None and less.step(lines, thresholds.STEPS, own=True):
            found.append(try_refine(evaluator, less.fit()))
    return found


def _stretched(
    evaluator: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    effects: Sequence[Effect],
) -> list[CandidateFit]:
    """A set with one more effect that its tolerances suggest."""
    able = [e for e in effects if not any(e.is_alike(o) for o in base.effects)]
    set_out(evaluator, base)
    try:
        return fit_stretched(Linearisation(evaluator, base), criterion, able)
    except BraceError:
        return []


def _part(say: Say, number: int) -> Say:
    begin, end = [(0.0, 0.4), (0.4, 0.85), (0.85, 1.0)][number - 1]
    return lambda what, share: say(what, begin + (end - begin) * share)

"""The search for causes: forward and backward over sets of effects.

From the nominal twin, then from the best sets so far, every further effect is
screened by a linearised replay. The best predicted ones are searched, the best
of these fitted to their end. The best set is also led on without each of its
effects, and in the end with others in their places that act like them.
The search ends where one more improves nothing, or nothing is left (stepwise
selection with a beam; Hastie, Tibshirani, Friedman, The Elements of Statistical
Learning, section 3.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from brace_drake.core.errors import BraceError
from brace_drake.core.progress import part_of
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, cost_of, refined
from brace_drake.selection.level import with_level
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.selection.search.backward import without_each
from brace_drake.selection.search.beyond import fit_beyond
from brace_drake.selection.search.exchange import exchanged
from brace_drake.selection.search.friction import (
    fit_behind_joints,
    fit_friction,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.nested import search_richer
from brace_drake.selection.search.screening import (
    Say,
    by_effect,
    others,
    search_best,
)
from brace_drake.selection.search.sets import (
    beam_of,
    ended_beside,
    screen_fresh,
    untried,
)
from brace_drake.selection.search.shortlist import (
    best_fits,
    improve_choices,
    refine,
    rivals,
    weighed_alike,
)
from brace_drake.selection.search.within import (
    refit_alone,
    refit_within,
    set_out,
    starts_beside,
)
from brace_drake.selection.tolerated import left_by

# Of the progress: sets of one effect, of two, of three.
_SHARES = (0.0, 0.4), (0.4, 0.85), (0.85, 1.0)


def search_causes(
    evaluator: Evaluator,
    criterion: Criterion,
    say: Say,
    is_law: Callable[[Criterion, list[CandidateFit]], bool] | None = None,
) -> list[CandidateFit]:
    """Fits of all single effects and of the sets that they lead to.

    Args:
        evaluator: Over the fit runs.
        criterion: With the nominal fit.
        say: Progress.
        is_law: Whether a short law takes what the fits leave.
    """
    effects = evaluator.effects
    few = [e for e in effects if not e.is_flexible]
    known: list[CandidateFit] = []
    beam, ranked = [criterion.nominal], [criterion.nominal]
    most = math.inf
    for number in range(1, thresholds.MOST_EFFECTS + 1):
        part = part_of(say, *_SHARES[number - 1])
        earlier = refined(known)
        for base in beam:
            known += _beside(evaluator, criterion, base, few, known, part, most)
        if number > 1:
            known += without_each(evaluator, criterion, known, number)
        ranked = best_of_kinds(criterion, [criterion.nominal, *known])
        best = ranked[0]
        # Friction that is found within its tolerance adds to the level.
        criterion = with_level(evaluator, criterion, best).over(known)
        if not criterion.may_pay(best):
            break
        before, least = (
            min([criterion.nominal, *fits], key=criterion.weighed)
            for fits in (earlier, refined(known))
        )
        after = criterion.weighed(least)
        worth = thresholds.WORTH_A_SET * criterion.weighed(before)
        if after > worth:
            break
        beam = beam_of(criterion, known, number)
        beam = [f for f in beam if len(f.effects) < evaluator.room]
        # Even if one more took as much as the first has to.
        next_score = math.log(after) + cost_of(number + 1) - cost_of(1)
        is_hopeless = number > 1 and next_score > criterion.score(best)
        # What numbers are stretched to may be another effect.
        is_whole = criterion.stretch(least) <= thresholds.WITHIN
        if is_hopeless and is_whole:
            # Then only where screening tells of one that pays.
            most = criterion.pays_below(best, number + 1)
    known += exchanged(evaluator, criterion, ranked[0], known)
    ranked = best_of_kinds(criterion, [criterion.nominal, *known])
    if _is_end(evaluator, criterion, ranked[0]):
        return known
    # Effects of dozens of parameters are dear, and cover what others and laws
    # of a few do: they are tried where those leave something.
    many = [e for e in effects if e.is_flexible]
    if many and is_law is not None and is_law(criterion, known):
        return known
    none = next(f for f in ranked if not criterion.findings(f))
    bases = [none] if ranked[0] is none else [none, ranked[0]]
    part = part_of(say, *_SHARES[-1])
    for base in bases:
        known += _beside(evaluator, criterion, base, many, known, part)
    # Where one of them is the best, others may be needless or take the rest.
    best = _best(criterion, none, known)
    while best.is_flexible:
        number = len(criterion.findings(best))
        known += without_each(evaluator, criterion, known, number)
        before, best = best, _best(criterion, none, known)
        if best is before:
            break
    if best.is_flexible:
        known += _beside(evaluator, criterion, best, few, known, part)
    return known


def _beside(
    evaluator: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    effects: Sequence[Effect],
    known: Sequence[CandidateFit],
    say: Say,
    most: float = math.inf,
) -> list[CandidateFit]:
    """Sets with one more effect, beside tolerances as they act there; `most` as
    of `_forward`.
    """
    set_out(evaluator, base)
    found: list[CandidateFit] = []
    try:
        if most < math.inf:
            lines = Linearisation(evaluator, base)
            if not screen_fresh(lines, effects, known, say, most):
                return found
        if base.effects and not base.is_settled:
            base = refit_within(evaluator, base, criterion.nuisances)
            found.append(base)
        if not criterion.may_pay(base):
            return found
        lines = Linearisation(evaluator, base)
        say("friction", 0.0)
        found += fit_friction(lines, criterion, untried(lines, known))
        best = _best(criterion, base, found)
        # Friction within its tolerance stays in where it hides all else.
        is_within = criterion.named(best) == criterion.named(base)
        if is_within and best.excess < thresholds.WORTH_A_SET * base.excess:
            base = best
        sticks = base is best and any(e.dithered for e in base.effects)
        if sticks and not _is_end(evaluator, criterion, best):
            set_out(evaluator, base)
            here = Linearisation(evaluator, base)
            found += fit_behind_joints(here, criterion)
            best = _best(criterion, base, found)
        if _is_end(evaluator, criterion, best):
            set_out(evaluator, base)
            return found
        if len(base.effects) == evaluator.room:
            return found
        found += fit_beyond(evaluator, base, criterion)
        for start in starts_beside(evaluator, base):
            lines, done = Linearisation(evaluator, start), [*known, *found]
            # What a start predicts that was not fitted is no bound.
            limit = most if start.excess <= base.excess else math.inf
            larger, told = _forward(lines, criterion, effects, done, say, limit)
            found += larger
            if told:
                break
            ended = ended_beside(base, [*known, *found])
            left = (left_by(f, evaluator.count) for f in ended)
            most = min([most, *left])
    except BraceError:
        # The twin breaks down where the search would set out.
        pass
    return found


def _forward(
    lines: Linearisation,
    criterion: Criterion,
    effects: Sequence[Effect],
    known: Sequence[CandidateFit],
    say: Say,
    most: float,
) -> tuple[list[CandidateFit], bool]:
    """A set with one more effect, and whether no other could better the best.

    Args:
        lines: Where the search sets out from.
        criterion: Of the campaign.
        effects: Those that may be added.
        known: Fits before; sets led to their end are not made again.
        say: Progress.
        most: What a candidate that is searched is predicted to leave at most.
    """
    evaluator, base = lines.evaluator, lines.base
    more, found, told = others(effects, base), [], False
    screened = screen_fresh(lines, effects, known, say, most)
    if not screened:
        return found, told
    # Those of dozens of parameters are dear: one after the other.
    is_dear = any(c.added.is_flexible for c in screened)
    for candidates in by_effect(screened) if is_dear else [screened]:
        hopeless = thresholds.HOPELESS_OF_MANY * lines.remaining
        if is_dear and candidates[0].predicted > hopeless:
            found += best_fits(candidates)
            continue
        evaluator.tolerances = lines.whole_tolerances
        search_best(lines, candidates, say)
        fits = ended_beside(base, [*known, *found])
        fits = [weighed_alike(evaluator, f) for f in fits]
        fits += best_fits(candidates)
        richer = search_richer(lines, fits, more)
        fits = best_fits([*candidates, *richer])
        fits = refine(evaluator, fits, lines.remaining)
        fits = improve_choices(lines, fits)
        found += [*fits, *refit_alone(evaluator, fits)]
        told = _is_told(lines, criterion, known, found)
        if told:
            break
    return found, told


def _is_told(
    lines: Linearisation,
    criterion: Criterion,
    known: Sequence[CandidateFit],
    found: list[CandidateFit],
) -> bool:
    """Whether no effect more could better the best so far.

    That is led on first, and rivals that come near it, each with tolerances
    linearised where it stands and with the friction that they allow for.
    """
    evaluator, base = lines.evaluator, lines.base
    best = _best(criterion, base, [*known, *found])
    for place in rivals(criterion, base, best, found):
        set_out(evaluator, found[place])
        fit = refit_within(evaluator, found[place], criterion.nuisances)
        led = [] if fit.solution is found[place].solution else [fit]
        found[place], friction = fit, []
        if not _is_end(evaluator, criterion, fit):
            here = Linearisation(evaluator, fit)
            more = untried(here, [*known, *found])
            friction = fit_friction(here, criterion, more)
        found += [*friction, *refit_alone(evaluator, [*led, *friction])]
    end = _best(criterion, base, [*known, *found])
    return _is_end(evaluator, criterion, end)


def _is_end(
    evaluator: Evaluator, criterion: Criterion, fit: CandidateFit
) -> bool:
    """Whether no effect more could better a fit's score."""
    return not with_level(evaluator, criterion, fit).may_pay(fit)


def _best(
    criterion: Criterion, base: CandidateFit, fits: Sequence[CandidateFit]
) -> CandidateFit:
    return min([base, *refined(fits)], key=criterion.score)

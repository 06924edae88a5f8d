"""The search for causes: screening, a shortlist, and pairs if need be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from brace_drake.effects.registry import effects_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, make_criterion
from brace_drake.selection.null_bootstrap import draw_null
from brace_drake.selection.search.candidate import Candidate
from brace_drake.selection.search.forward import SecondEffects
from brace_drake.selection.search.friction import (
    fit_alone,
    fit_frictions,
    is_settled,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.nested import search_richer
from brace_drake.selection.search.screening import Say, screen, search_best
from brace_drake.selection.search.shortlist import (
    best_fits,
    improve_choices,
    refine,
)
from brace_drake.selection.search.small_second import try_small


class Searched(NamedTuple):
    """What a search over all causes has come to.

    Attributes:
        fits: Of single causes and pairs, the shortlist among them refined.
        criterion: With the null distribution of noise alone.
        is_cut: Whether the search for second effects ended because it had cost
            too much.
        shown: Effects that show on imposed motion, where that was asked: an
            explanation has to have them.
    """

    fits: list[CandidateFit]
    criterion: Criterion
    is_cut: bool = False
    shown: frozenset[str] = frozenset()


def search_causes(
    evaluator: Evaluator,
    nominal: CandidateFit,
    seed: int,
    say: Say,
    holds_at_rest: bool | None = None,
    explain_imposed: Callable[[Say], CandidateFit | None] = lambda say: None,
) -> Searched:
    """Fits of all causes, and of pairs where no single one explains the gap.

    Effects of dozens of parameters are tried only where there is something
    left that no simpler one explains; those that show in the leg lengths at
    rest first where these are off, and not at all where they hold.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        seed: Of the simulated fault-free campaigns.
        say: Progress.
        holds_at_rest: Whether the leg lengths at rest are as they should be,
            None where that is not known.
        explain_imposed: Explains what shows on imposed motion alone; asked
            where drives stick, as a second effect is lost there in what no
            twin follows.
    """
    effects = [
        e
        for e in effects_for(evaluator.twin.device).values()
        if not (e.is_flexible and e.at_rest and holds_at_rest)
    ]
    base = Linearisation(evaluator, nominal)
    criterion = make_criterion(evaluator, nominal)
    many, simple = _divide(effects, lambda e: e.is_flexible)
    flexible: list[CandidateFit] = []
    if holds_at_rest is False and not criterion.is_almost_near_floor(nominal):
        at_rest, many = _divide(many, lambda e: e.at_rest)
        part = _part(say, 0.1, 0.2)
        flexible = _fit_many(base, criterion, at_rest, part)
    most = criterion.largest_excess(1)
    least = min((max(f.excess, 0.0) for f in flexible), default=np.inf)
    found: list[Candidate] = []
    if any(criterion.is_almost_near_floor(f) for f in flexible):
        # Of the others only what may explain it too needs a search.
        simple, others = _divide(simple, lambda e: e.at_rest)
        part = _part(say, 0.2, 0.3)
        found = screen(base, others, part)
        search_best(base, found, part, 1, most, most, least=least)
    part = _part(say, 0.2, 0.4)
    first = screen(base, simple, part)
    search_best(base, first, part, enough=most, least=least)
    found += first
    found += search_richer(base, found, simple)
    say("shortlist", 0.4)
    # Those that explain nothing are not compared to the last digit.
    fits = refine(evaluator, best_fits(found), nominal.excess, rivals=most)
    fits = improve_choices(base, fits, most)
    null = draw_null(evaluator, nominal, fits, seed)
    criterion = replace(criterion, null=null)
    if criterion.misfit(nominal) <= thresholds.TWIN_ERROR:
        return Searched([*fits, *flexible], criterion)
    shown: frozenset[str] = frozenset()
    frictions = criterion.sticking([*fits, *flexible])
    imposed = explain_imposed(_part(say, 0.4, 0.42)) if frictions else None
    if imposed is not None:
        part, shown = _part(say, 0.42, 0.45), imposed.kinds
        pairs = fit_frictions(evaluator, frictions, imposed, effects, part)
        alone = fit_alone(evaluator, imposed) if shown else None
        fits = _best_of_name([*fits, *pairs, *([alone] if alone else [])])
        if shown and is_settled(criterion, pairs, alone):
            return Searched([*fits, *flexible], criterion, False, shown)
        if not shown:
            # Nor is a second effect one that would show there.
            _, effects = _divide(effects, lambda e: e.answers_motion)
            _, many = _divide(many, lambda e: e.answers_motion)
            found = [c for c in found if c.added in effects]
    singles = [f for f in fits if len(f.effects) == 1]
    known, second = [*fits, *flexible], None
    pair_of = partial(
        SecondEffects, base, effects, singles, found, criterion, seed
    )
    if not _is_done(criterion, known):
        second, is_found = pair_of(), False
        if flexible:
            is_found = second.try_at_rest(flexible, _part(say, 0.4, 0.45))
        if is_found or second.try_pairs(_part(say, 0.45, 0.55)):
            pairs = second.search([], say)
            return Searched([*known, *pairs], criterion, False, shown)
    if not criterion.is_near_floor(known):
        flexible += _fit_many(base, criterion, many, _part(say, 0.55, 0.6))
        known = [*fits, *flexible]
    part = _part(say, 0.6, 0.78)
    if _is_done(criterion, known):
        alone, pairs = [*singles, *flexible], second.found if second else []
        pairs = try_small(
            criterion, evaluator, alone, effects, pairs, seed, part
        )
        return Searched([*known, *pairs], criterion, False, shown)
    second = second or pair_of()
    pairs = second.search(flexible, part)
    return Searched([*known, *pairs], criterion, second.is_cut, shown)


def _is_done(criterion: Criterion, known: Sequence[CandidateFit]) -> bool:
    """Whether there is nothing for a second effect: what the best leaves is
    what noise leaves too, or there is no gap.
    """
    if criterion.is_near_floor(known):
        return True
    return not (known and criterion.has_gap(known))


def _fit_many(
    base: Linearisation, criterion: Criterion, effects, say: Say
) -> list[CandidateFit]:
    """Fits of effects of dozens of parameters, refined where they are near
    the floor and close about half of the gap.

    With so much freedom less is no sign of them, and the end of their search
    is dear. What leaves more may have another effect beside.
    """
    found = screen(base, effects, say)
    search_best(base, found, say, places=0)
    fits = best_fits(found)
    good, rest = _divide(
        fits,
        lambda f: (
            criterion.is_almost_near_floor(f) and criterion.closes_half(f)
        ),
    )
    return [*refine(base.evaluator, good, base.base.excess), *rest]


def _best_of_name(fits: list[CandidateFit]) -> list[CandidateFit]:
    """Of fits of the same effects the refined one that leaves least."""
    best: dict[str, CandidateFit] = {}
    for fit in sorted(fits, key=lambda f: (not f.refined, f.excess)):
        best.setdefault(fit.name, fit)
    return list(best.values())


def _divide(items, is_first) -> tuple[list, list]:
    first = [i for i in items if is_first(i)]
    return first, [i for i in items if not is_first(i)]


def _part(say: Say, begin: float, end: float) -> Say:
    return lambda what, share: say(what, begin + (end - begin) * share)

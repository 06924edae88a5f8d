"""The search over all causes: a race, contenders, and pairs if need be."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import effects_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.isolation.imposed_motion import is_on_contact_side
from brace_drake.selection.acceptance import (
    is_almost_near_floor,
    largest_excess,
)
from brace_drake.selection.decision import has_gap, is_near_floor
from brace_drake.selection.measures import closes_half, is_exact
from brace_drake.selection.null_bootstrap import NullDistribution, draw_null
from brace_drake.selection.search.beside_friction import (
    fit_alone,
    fit_frictions,
    is_settled,
    sticking,
)
from brace_drake.selection.search.candidate import Runner
from brace_drake.selection.search.forward import Say, SecondEffects
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.nested import race_richer
from brace_drake.selection.search.screening import race
from brace_drake.selection.search.shortlist import best_fits, polish, refine


class Searched(NamedTuple):
    """What a search over all causes has come to.

    Attributes:
        fits: Of single causes and pairs, the contenders among them refined.
        null: What noise alone gives.
        is_cut: Whether the search for second effects ended because it had cost
            too much.
        shown: Effects that the contact's side shows, where it was asked: an
            explanation has to have them.
    """

    fits: list[CandidateFit]
    null: NullDistribution
    is_cut: bool = False
    shown: frozenset[str] = frozenset()


def try_causes(
    evaluator: Evaluator,
    nominal: CandidateFit,
    seed: int,
    say: Say,
    holds_at_rest: bool | None = None,
    see_side: Callable[[Say], CandidateFit | None] = lambda say: None,
) -> Searched:
    """Fits of all causes, of pairs where no single one explains the gap.

    Effects of dozens of parameters are tried only where there is something
    left that no simpler one explains; those that show in the leg lengths at
    rest first where these are off, and not at all where they hold.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        seed: Of the surrogates.
        say: Progress.
        holds_at_rest: Whether the leg lengths at rest are as they should be,
            None where that is not known.
        see_side: Explains the contact's side alone; asked where drives stick,
            as a second effect is lost there in what no twin follows.
    """
    cards = _candidates(evaluator.twin.device, holds_at_rest)
    ground = Ground(evaluator, nominal)
    most = largest_excess(evaluator, nominal, 1)
    is_off = holds_at_rest is False
    runners, flexible, many = _race_all(ground, cards, is_off, most, say)
    say("contenders", 0.4)
    # Those that explain nothing are not compared to the last digit.
    fits = refine(evaluator, best_fits(runners), nominal.excess, rivals=most)
    fits = polish(ground, fits, most)
    null = draw_null(evaluator, nominal, fits, seed)

    def is_near():
        known = [*fits, *flexible]
        limit = null.misfit_threshold
        return is_near_floor(evaluator, nominal, known, limit)

    def is_done():
        known = [*fits, *flexible]
        # In what surrogates leave too there is nothing for a second effect.
        return is_near() or not (
            known and has_gap(evaluator, nominal, known, null)
        )

    if is_exact(evaluator, nominal):
        return Searched([*fits, *flexible], null)
    frictions = sticking(evaluator, [*fits, *flexible], null.misfit_threshold)
    side = see_side(_part(say, 0.4, 0.42)) if frictions else None
    shown: frozenset[str] = side.kinds if side else frozenset()
    if side is not None:
        part = _part(say, 0.42, 0.45)
        found = fit_frictions(evaluator, frictions, side, cards, part)
        alone = fit_alone(evaluator, side) if shown else None
        fits = _best_of_name([*fits, *found, *([alone] if alone else [])])
        if shown and is_settled(evaluator, nominal, found, alone, null):
            return Searched([*fits, *flexible], null, False, shown)
        if not shown:
            # Nor is a second effect on that side.
            _, cards = _divide(cards, is_on_contact_side)
            _, many = _divide(many, is_on_contact_side)
            runners = [r for r in runners if r.card in cards]
    singles = [f for f in fits if len(f.effects) == 1]
    second = SecondEffects(ground, cards, singles, runners, null, seed)
    is_found = False
    if flexible and not is_done():
        is_found = second.try_at_rest(flexible, _part(say, 0.4, 0.45))
    if not (is_found or is_done()):
        is_found = second.try_pairs(_part(say, 0.45, 0.55))
    if is_found:
        found = second.search([], say)
        return Searched([*fits, *flexible, *found], null, False, shown)
    if not is_near():
        flexible += _race_flexible(ground, many, _part(say, 0.55, 0.6))
    if not is_done():
        found = second.search(flexible, _part(say, 0.6, 0.78))
        fits = [*fits, *flexible, *found]
        return Searched(fits, null, second.is_cut, shown)
    small = second.try_small(flexible, _part(say, 0.6, 0.78))
    return Searched([*fits, *flexible, *small], null, False, shown)


def _race_all(
    ground: Ground, cards: list[Effect], is_off: bool, most: float, say: Say
) -> tuple[list[Runner], list[CandidateFit], list[Effect]]:
    """A race of all cards of few parameters; before it one of those that show
    in the leg lengths at rest, where these are off.

    Returns:
        Runners of few parameters, fits of dozens, cards of dozens not tried.
    """
    evaluator, nominal = ground.evaluator, ground.leader
    many, simple = _divide(cards, lambda c: c.is_flexible)
    flexible: list[CandidateFit] = []
    if is_off and not is_almost_near_floor(evaluator, nominal):
        at_rest, many = _divide(many, lambda c: c.at_rest)
        flexible = _race_flexible(ground, at_rest, _part(say, 0.1, 0.2))
    runners = []
    least = min((max(f.excess, 0.0) for f in flexible), default=np.inf)
    if any(is_almost_near_floor(evaluator, f) for f in flexible):
        # Of the others only who may explain it too needs a search.
        simple, others = _divide(simple, lambda c: c.at_rest)
        part = _part(say, 0.2, 0.3)
        runners = race(
            ground, others, part, places=1, bar=most, most=most, least=least
        )
    part = _part(say, 0.2, 0.4)
    runners += race(ground, simple, part, most=most, least=least)
    runners += race_richer(ground, runners, simple)
    return runners, flexible, many


def _best_of_name(fits: list[CandidateFit]) -> list[CandidateFit]:
    """Of fits of the same effects the refined one that leaves least."""
    best: dict[str, CandidateFit] = {}
    for fit in sorted(fits, key=lambda f: (not f.refined, f.excess)):
        best.setdefault(fit.name, fit)
    return list(best.values())


def _candidates(device: str, holds_at_rest: bool | None) -> list[Effect]:
    """Cards to try; of dozens of parameters none that must show at rest and
    does not.
    """
    return [
        c
        for c in effects_for(device).values()
        if not (c.is_flexible and c.at_rest and holds_at_rest)
    ]


def _divide(cards, is_first) -> tuple[list[Effect], list[Effect]]:
    first = [c for c in cards if is_first(c)]
    return first, [c for c in cards if not is_first(c)]


def _race_flexible(ground: Ground, cards, say) -> list[CandidateFit]:
    fits = best_fits(race(ground, cards, say, places=0))
    return _refine_flexible(ground.evaluator, ground.leader, fits)


def _refine_flexible(evaluator, nominal, flexible) -> list[CandidateFit]:
    """Flexible fits, refined where they are near the floor and close about
    half of the gap.

    With so much freedom less is no sign of them, and the end of their search
    is dear. Who leaves more may have another effect beside.
    """
    good, rest = [], []
    for fit in flexible:
        is_near = is_almost_near_floor(evaluator, fit)
        is_good = is_near and closes_half(evaluator, nominal, fit)
        (good if is_good else rest).append(fit)
    return [*refine(evaluator, good, nominal.excess), *rest]


def _part(say, begin: float, end: float):
    return lambda what, share: say(what, begin + (end - begin) * share)

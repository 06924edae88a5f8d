"""Screening: each effect's predicted gain, then a short search of the best.

One replay for each start of an effect, linearised, predicts what it could
explain; those that are predicted to leave least are searched a few steps each.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.search.candidate import Candidate, with_one_more
from brace_drake.selection.search.linearisation import Linearisation

Say = Callable[[str, float], None]


def silent(what: str, share: float) -> None:
    """Progress that nobody wants to hear of."""


def screen(
    base: Linearisation,
    effects: Sequence[Effect],
    say: Say = silent,
    is_quick: bool = False,
) -> list[Candidate]:
    """The base's effects with each of the given ones, from each start.

    Args:
        base: Where to set out from.
        effects: One more each.
        say: Progress.
        is_quick: Whether few starts are taken, and each as it is.

    Returns:
        Candidates with the excess that each is predicted to leave.
    """
    name = f"{base.base.name}+" if base.base.effects else ""

    def one(i, effect):
        say(f"cause {name}{effect.key}", 0.6 * i / len(effects))
        return predict(base, effect, is_quick)

    found = base.evaluator.together(
        [partial(one, i, effect) for i, effect in enumerate(effects)]
    )
    return [candidate for candidates in found for candidate in candidates]


def others(effects: Sequence[Effect], fit: CandidateFit) -> list[Effect]:
    """Effects that are no other form of what a fit has.

    Args:
        effects: All that there are.
        fit: With one effect or more.
    """
    return [e for e in effects if not any(e.is_alike(o) for o in fit.effects)]


def by_effect(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Candidates of each set of effects, first of what is predicted to leave
    least.
    """
    groups: dict[str, list[Candidate]] = {}
    for candidate in sorted(candidates, key=lambda c: c.predicted):
        groups.setdefault(candidate.name, []).append(candidate)
    return list(groups.values())


def _best_starts(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best start of each set of effects, with the best one from another
    start: from one time constant, or one width of a loop, no way may lead to
    another.
    """
    groups = by_effect(candidates)
    for first, *more in groups:
        if not first.added.is_flexible:
            elsewhere = (c for c in more if c.start != first.start)
            first.others = tuple(itertools.islice(elsewhere, 1))
    return [first for first, *_ in groups]


def search_best(
    base: Linearisation,
    candidates: Sequence[Candidate],
    say: Say = silent,
    places: int = thresholds.PLACES,
) -> None:
    """Searches the candidates that are predicted to leave least, best first,
    a few side by side.

    None is searched where the base leaves nothing to explain.

    Args:
        base: Where they set out from.
        candidates: With what they are predicted to leave.
        say: Progress.
        places: So many are searched whatever is predicted.
    """
    if base.is_exact:
        return
    starts = candidates
    candidates, best = _best_starts(candidates), _Best()
    trust = thresholds.COARSE * base.evaluator.count
    remaining, most = base.remaining, _most(base)
    worth = max(trust, thresholds.WORTH_A_PLACE * remaining)

    def is_worth(place, left):
        if place >= thresholds.HOPELESS_PLACES and left > most:
            return False
        far_behind = left > thresholds.FACTOR * (best.left + trust)
        return place < places or not (far_behind or remaining - left < worth)

    def search_starts(candidate):
        for start in (candidate, *candidate.others):
            if _search(base, start, best):
                best.left = max(0.0, min(best.left, start.left))
            start.forget_jacobian()
            # Where one has come to the floor no other way need be tried.
            if best.left <= trust:
                break

    ranked, at_once = list(enumerate(candidates)), thresholds.AT_ONCE
    # The first alone: often no other comes near it.
    batches = [ranked[:1]]
    batches += [ranked[i : i + at_once] for i in range(1, len(ranked), at_once)]
    for batch in batches:
        if best.left <= trust:
            places = min(places, thresholds.PLACES_AT_FLOOR)
        few = [(place, c) for place, c in batch if is_worth(place, c.left)]
        for place, c in few:
            say(f"cause {c.name}", 0.6 + 0.4 * place / len(candidates))
        base.evaluator.together([partial(search_starts, c) for _, c in few])
        if len(few) < len(batch):
            break
    for start in starts:
        start.forget_jacobian()


def _most(base: Linearisation) -> float:
    """What a candidate is predicted to leave at most."""
    if base.base.is_dithered:
        return thresholds.HOPELESS_ROUGH * base.remaining
    return thresholds.HOPELESS * base.remaining


@dataclass
class _Best:
    """The least excess that a search has left so far, strained."""

    left: float = np.inf


def _search(base: Linearisation, candidate: Candidate, best: _Best) -> bool:
    """Rounds of steps while they bring much; False if its twin breaks down.

    One that would not come near the best at the rate of the last round is
    given up.
    """
    count = base.evaluator.count
    trust = end = thresholds.COARSE * count
    if candidate.added.spread is not None:
        end = thresholds.COARSE_OF_MANY * count
    before, predicted = np.inf, candidate.predicted

    def near_best():
        return thresholds.FACTOR * (best.left + trust)

    for done in range(1, thresholds.ROUNDS + 1):
        if not candidate.step(base, thresholds.STEPS):
            return False
        left = candidate.left
        rate = left / before
        if left < end or rate > thresholds.WORTH_A_ROUND:
            break
        is_first, rounds = done == 1, thresholds.ROUNDS - done
        near = thresholds.AS_PREDICTED
        if is_first and np.isclose(left, predicted, rtol=near):
            break
        rate = thresholds.BEST_ROUND if is_first else rate
        if left * rate**rounds > near_best():
            break
        before = left
    has_failed = end < left and predicted < thresholds.FAILED * left
    if predicted < near_best() and has_failed:
        # Far from the base its sensitivities may lead nowhere.
        return candidate.step(base, thresholds.STEPS, own=True)
    return True


def predict(
    base: Linearisation, effect: Effect, is_quick: bool = False
) -> list[Candidate]:
    """An effect beside the base's, at each of its starts, with predictions.

    A start that is far too strong or too weak, or of the wrong sign, is
    followed by one of the strength that it predicts.

    Args:
        base: Where to set out from.
        effect: The one more.
        is_quick: Whether none is, and few starts are taken.
    """
    found: list[Candidate] = []
    most = _most(base)
    starts, tries = [*effect.starts()], thresholds.RESCALED + 1
    if is_quick:
        few = min(len(starts), thresholds.QUICK_STARTS)
        places = np.linspace(0, len(starts) - 1, few).astype(int)
        starts, tries = [starts[i] for i in places], 1
    for values in starts:
        start = tuple(values[effect.has_several_starts])
        for _ in range(tries):
            candidate = with_one_more(base, effect, values)
            if candidate is None:
                break
            candidate.start = start
            candidate.predicted, far = base.predict_excess(
                candidate.problem,
                candidate.z,
                candidate.residual,
                effect.has_either_sign,
            )
            found.append(candidate)
            if effect.is_continuous.sum() > thresholds.STRAIGHT_PARAMETERS:
                if candidate.step(base, 1):
                    # With what the base's parameters cost, where that counts.
                    candidate.predicted = candidate.excess
                break
            is_strong_enough = thresholds.ENOUGH < far < 1.0 / thresholds.ENOUGH
            if effect.run_parameters or is_strong_enough:
                break
            if base.is_exact:
                return found
            if candidate.predicted > most:
                break
            factor = np.copysign(max(abs(far), thresholds.WEAKEST), far)
            rescaled = effect.scaled(values, factor)
            if np.allclose(rescaled, values, rtol=0.1, atol=0.0):
                break
            values = rescaled
    return found

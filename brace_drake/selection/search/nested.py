"""Nested models: from a special case to the richer effect, and back.

Where drives stick and slip every parameter changes which slip comes when, and
from afar no way leads on: dry friction that falls with speed is found from dry
friction that does not.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.search.candidate import Candidate, make_candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.shortlist import best_fits


def richer_starts(
    effect: Effect, special: Effect, values: np.ndarray
) -> Iterator[np.ndarray]:
    """Values of an effect that do nearly what its special case does.

    A part of the strength goes to each parameter that the special case has
    not, half of that part is taken off those that it has.
    """
    known = dict(zip(special.parameter_names, values, strict=False))
    strength = max(abs(v) for v in known.values())
    axes = []
    for p in effect.parameters:
        if p.name in known:
            axes.append([None])
        elif p.off == 0.0:
            axes.append([s * strength for s in thresholds.NESTED_SHARES])
        else:
            axes.append([t * p.starts[0] for t in thresholds.NESTED_SHAPES])
    for chosen in itertools.product(*axes):
        added = sum(
            v
            for p, v in zip(effect.parameters, chosen, strict=True)
            if v is not None and p.off == 0.0
        )
        less = 1.0 - 0.5 * added / strength
        yield np.clip(
            [
                known[p.name] * less if v is None else v
                for p, v in zip(effect.parameters, chosen, strict=True)
            ],
            effect.lower,
            effect.upper,
        )


def search_richer(
    base: Linearisation,
    candidates: Sequence[Candidate],
    effects: Sequence[Effect],
) -> list[Candidate]:
    """Richer effects in the place of special cases near the best candidate.

    Args:
        base: The fit that the candidates set out from.
        candidates: After screening.
        effects: Those that may be richer.
    """
    if base.is_exact:
        return []
    fits = [f for f in best_fits(candidates) if f.is_searched]
    least = min((f.excess for f in fits), default=np.inf)
    near = thresholds.NESTED_NEAR * max(0.0, least)
    return [
        candidate
        for fit in fits
        if fit.excess <= near
        for place in range(len(fit.effects))
        for candidate in _richer_in(base, fit, effects, place)
    ]


def _richer_in(
    base: Linearisation,
    fit: CandidateFit,
    effects: Sequence[Effect],
    place: int,
) -> list[Candidate]:
    """Richer effects in the place of one of a fit's, searched where they begin
    better than it has ended.
    """
    special, values = fit.uses[place]
    out = []
    for effect in effects:
        if not effect.is_richer_than(special):
            continue
        if any(effect.is_alike(e) for e in fit.effects if e is not special):
            continue
        found = []
        for start in richer_starts(effect, special, values):
            both, strengths = list(fit.effects), list(fit.values)
            both[place], strengths[place] = effect, start
            candidate = make_candidate(
                base, both, strengths, fit.subject, fit.spread
            )
            if candidate is not None:
                found.append(candidate)
        best = min(found, key=lambda c: c.excess, default=None)
        better = thresholds.NESTED_BETTER * fit.excess
        if best is None or best.excess > better:
            continue
        before = np.inf
        for _ in range(thresholds.NESTED_ROUNDS):
            if not best.step(base, thresholds.NESTED_STEPS, own=True):
                break
            if best.excess > thresholds.NESTED_WORTH * before:
                break
            before = best.excess
        out.append(best)
    return out


def special_cases(
    base: Linearisation, pair: CandidateFit, effects: Sequence[Effect]
) -> Iterator[Candidate]:
    """The pair with a special case of either effect in its place, parameters
    that both have as they are.
    """
    for (out, values), kept in itertools.permutations(pair.uses):
        there = dict(zip(out.parameter_names, values, strict=False))
        for effect in effects:
            if not out.is_richer_than(effect):
                continue
            start = dict(
                zip(effect.parameter_names, effect.starts()[0], strict=True)
            )
            # From no strength at all no way leads on.
            mine = np.array([there.get(n) or v for n, v in start.items()])
            both, strengths = zip(kept, (effect, mine), strict=True)
            candidate = make_candidate(
                base, both, strengths, pair.subject, pair.spread
            )
            if candidate is not None:
                yield candidate


def confused_with_many(
    base: Linearisation, pair: CandidateFit, effects: Sequence[Effect]
) -> Iterator[Candidate]:
    """The pair with an effect of many parameters, drawn alike, in the place of
    one that is confused with it.
    """
    for (out, _), kept in itertools.permutations(pair.uses):
        for effect in effects:
            if effect.spread is None or effect.is_alike(kept[0]):
                continue
            if out.name not in effect.impostors:
                continue
            both, values = zip(kept, (effect, effect.off()), strict=True)
            candidate = make_candidate(base, both, values, pair.subject)
            if candidate is not None:
                yield candidate

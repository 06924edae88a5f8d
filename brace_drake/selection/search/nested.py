"""Nested models: from a special case to the richer effect, and back.

Where drives stick and slip every parameter changes which slip comes when, and
from afar no way leads on: dry friction that falls with speed is found from dry
friction that does not.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.search.candidate import (
    Candidate,
    best_of_starts,
    make_candidate,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.tolerated import left_by


def richer_starts(
    effect: Effect, special: Effect, values: np.ndarray
) -> Iterator[np.ndarray]:
    """Values of an effect that do nearly what its special case does.

    A part of the strength goes to each parameter that the special case has
    not, half of that part is taken off those that it has.
    """
    known = dict(zip(special.parameter_names, values, strict=False))
    first = special.parameters[int(np.argmax(special.is_strength))]
    strength, axes = max(abs(v) for v in known.values()), []
    for p in effect.parameters:
        if p.name in known:
            axes.append([None])
        elif p.off == 0.0:
            axes.append(list(thresholds.NESTED_SHARES))
        else:
            axes.append([t * p.starts[0] for t in thresholds.NESTED_SHAPES])
    for chosen in itertools.product(*axes):
        out, added = [], 0.0
        for p, v in zip(effect.parameters, chosen, strict=True):
            if v is not None and p.off == 0.0:
                added += v
                # What is small in its unit is in that of its starts.
                v = v * strength * p.starts[0] / first.starts[0]
            out.append(v)
        less = 1.0 - 0.5 * added
        yield np.clip(
            [
                known[p.name] * (less if p.off == 0.0 else 1.0)
                if v is None
                else v
                for p, v in zip(effect.parameters, out, strict=True)
            ],
            effect.lower,
            effect.upper,
        )


def special_cases(
    fit: CandidateFit, effects: Sequence[Effect]
) -> list[CandidateFit]:
    """A fit as it sets out with each special case of a richer effect in its
    place, or with each form of what the effect contains; empty where it has no
    richer one.

    Args:
        fit: Of any effects.
        effects: All that there are.
    """
    for i, (richer, values) in enumerate(fit.uses):
        cases = _cases_of(richer, effects)
        mine = dict(zip(richer.parameter_names, values, strict=False))
        found = []
        for case in cases:
            own = [mine.get(p.name, p.starts[0]) for p in case.parameters]
            every, each = list(fit.effects), list(fit.values)
            every[i], each[i] = case, np.array(own)
            more = replace(fit, effects=tuple(every), values=tuple(each))
            found.append(more)
        if found:
            return found
    return []


def _cases_of(richer: Effect, effects: Sequence[Effect]) -> list[Effect]:
    """The special cases of an effect, else all forms of what it contains."""
    cases = [e for e in effects if richer.is_richer_than(e)]
    if cases:
        return cases
    names = set(richer.parameter_names)
    return [
        e
        for e in effects
        if e.name in richer.contains
        and e.at == richer.at
        and names >= set(e.parameter_names)
    ]


def search_richer(
    base: Linearisation,
    fits: Sequence[CandidateFit],
    effects: Sequence[Effect],
) -> list[Candidate]:
    """Richer effects in the place of special cases near the best fit.

    Args:
        base: The fit that the others set out from.
        fits: After screening.
        effects: Those that may be richer.
    """
    if base.is_exact:
        return []
    fits = [f for f in fits if f.is_searched]
    count = base.evaluator.count
    left = [left_by(f, count) for f in fits]
    least = min(left, default=np.inf)
    near = thresholds.NESTED_NEAR * max(0.0, least)
    return [
        candidate
        for fit, mine in zip(fits, left, strict=True)
        if mine <= near
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
        better = thresholds.NESTED_BETTER * left_by(fit, base.evaluator.count)
        best = best_of_starts(base, [c for c in found if c.excess <= better])
        if best is not None:
            out.append(best)
    return out

"""Effects that set out from a special case of theirs, as it was found.

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
from brace_drake.selection.search.candidate import Runner, make_runner, step
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.shortlist import best_fits

# What is added to a special case begins as these parts of its strength; other
# numbers at so many times their start.
_PARTS, _TIMES = (0.1, 0.4), (0.5, 1.0, 2.0)
# One that begins no better than this share of what the special case leaves is
# not searched.
_BETTER = 0.9
# Of what the best has left, up to which a special case is one to set out from.
_NEAR = 2.0
# Steps of a round, and rounds as long as each leaves less than this share.
_STEPS, _ROUNDS, _WORTH_A_ROUND = 4, 3, 0.8


def richer_starts(
    card: Effect, special: Effect, values: np.ndarray
) -> Iterator[np.ndarray]:
    """Values of a card that do nearly what its special case does.

    A part of the strength goes to each parameter that the special case has
    not, half of that part is taken off those that it has.
    """
    known = dict(zip(special.parameter_names, values, strict=False))
    strength = max(abs(v) for v in known.values())
    axes = []
    for p in card.parameters:
        if p.name in known:
            axes.append([None])
        elif p.off == 0.0:
            axes.append([part * strength for part in _PARTS])
        else:
            axes.append([times * p.starts[0] for times in _TIMES])
    for chosen in itertools.product(*axes):
        added = sum(
            v
            for p, v in zip(card.parameters, chosen, strict=True)
            if v is not None and p.off == 0.0
        )
        less = 1.0 - 0.5 * added / strength
        yield np.clip(
            [
                known[p.name] * less if v is None else v
                for p, v in zip(card.parameters, chosen, strict=True)
            ],
            card.lower,
            card.upper,
        )


def search_richer(
    ground: Ground,
    fit: CandidateFit,
    cards: Sequence[Effect],
    place: int,
) -> list[Runner]:
    """The richer cards in the place of one effect of a fit, searched where
    they begin better than it has ended.

    Args:
        ground: The nominal fit.
        fit: Where a search has ended.
        cards: Those that may be richer.
        place: Of the effect among those of the fit.
    """
    special, values = fit.uses[place]
    out = []
    for card in cards:
        if not card.is_richer_than(special):
            continue
        if any(card.is_alike(e) for e in fit.effects if e is not special):
            continue
        runners = []
        for start in richer_starts(card, special, values):
            effects, both = list(fit.effects), list(fit.values)
            effects[place], both[place] = card, start
            runner = make_runner(ground, effects, both, fit.subject, fit.spread)
            if runner is not None:
                runners.append(runner)
        best = min(runners, key=lambda r: r.excess, default=None)
        if best is None or best.excess > _BETTER * fit.excess:
            continue
        before = np.inf
        for _ in range(_ROUNDS):
            if not step(ground, best, _STEPS, own=True):
                break
            if best.excess > _WORTH_A_ROUND * before:
                break
            before = best.excess
        out.append(best)
    return out


def race_richer(
    ground: Ground, runners: Sequence[Runner], cards: Sequence[Effect]
) -> list[Runner]:
    """Richer effects of those that a race has left near its best one."""
    if ground.is_exact:
        return []
    fits = [f for f in best_fits(runners) if f.is_searched]
    least = min((f.excess for f in fits), default=np.inf)
    near = [f for f in fits if f.excess <= _NEAR * max(0.0, least)]
    return [
        runner
        for fit in near
        for place in range(len(fit.effects))
        for runner in search_richer(ground, fit, cards, place)
    ]

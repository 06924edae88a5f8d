"""Ways to a pair of effects: afresh, from another one, or to one of its two."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.search.candidate import Runner, make_runner, step
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.pairs import Foreseen, line_up_pair
from brace_drake.selection.search.shortlist import try_refine

# Steps from a pair to either effect alone.
_STEPS = 4
# Rounds of the search of a pair that sets out afresh, of so many steps, as
# long as each leaves less than half of what there was.
_ROUNDS, _STEPS_AFRESH, _HALF = 3, 4, 0.5
# Strengths at which it sets out, in terms of those alone.
_STRENGTHS = 1.0, 0.5


def try_without_one(
    ground: Ground, pair: CandidateFit, least: float
) -> list[CandidateFit]:
    """Either effect of a pair alone, from where the pair has it.

    A pair whose one effect does little may show where the other belongs.

    Args:
        ground: The nominal fit.
        pair: A fit of two effects.
        least: Excess that one alone has to leave less than.
    """
    found = []
    for effect, values in pair.uses:
        runner = make_runner(
            ground, [effect], [values], pair.subject, pair.spread
        )
        if runner is not None and step(ground, runner, _STEPS):
            fit = runner.fit()
            if fit.excess < least:
                found.append(try_refine(ground.evaluator, fit))
    return found


def set_out_afresh(
    ground: Ground,
    pair: Foreseen,
    enough: float,
    say: Callable[[str, float], None],
) -> list[Runner]:
    """A pair that sets out from the subject's nominal parameters.

    Two large effects drive those of the nominal fit to their limits, from
    where no way may lead back. Alone each does what it can of the other's, so
    either may be too strong: what leaves least of both is where it begins.

    Args:
        ground: The nominal fit.
        pair: One that is foreseen.
        enough: Excess at which the search may end.
        say: Progress.

    Returns:
        It where it stands then; none where its twin breaks down.
    """
    subject = np.array([p.nominal for p in ground.evaluator.twin.subject])
    runners = [
        line_up_pair(ground, *pair[1:], subject, strengths)
        for strengths in itertools.product(_STRENGTHS, repeat=2)
    ]
    found = [r for r in runners if r is not None]
    if not found:
        return []
    runner = min(found, key=lambda r: r.excess)
    say(f"cause {runner.fit().name}", 0.9)
    before = ground.leader.excess
    for _ in range(_ROUNDS):
        if not step(ground, runner, _STEPS_AFRESH, own=True):
            break
        left = runner.fit().excess
        if left <= enough or left > _HALF * before:
            break
        before = left
    return [runner]


def make_simpler(
    ground: Ground, pair: CandidateFit, cards: Sequence[Effect]
) -> Iterator[Runner]:
    """The pair with a special case of either effect in its place, parameters
    that both have as they are.
    """
    for (out, values), kept in itertools.permutations(pair.uses):
        there = dict(zip(out.parameter_names, values, strict=False))
        for card in cards:
            if not out.is_richer_than(card):
                continue
            start = dict(
                zip(card.parameter_names, card.starts()[0], strict=True)
            )
            # From no strength at all no way leads on.
            mine = np.array([there.get(n) or v for n, v in start.items()])
            effects, both = zip(kept, (card, mine), strict=True)
            runner = make_runner(
                ground, effects, both, pair.subject, pair.spread
            )
            if runner is not None:
                yield runner


def make_richer(
    ground: Ground, pair: CandidateFit, cards: Sequence[Effect]
) -> Iterator[Runner]:
    """The pair with an effect of many parameters, drawn alike, in the place of
    one that is taken for it.
    """
    for (out, _), kept in itertools.permutations(pair.uses):
        for card in cards:
            if card.spread is None or card.is_alike(kept[0]):
                continue
            if out.name not in card.impostors:
                continue
            effects, values = zip(kept, (card, card.off()), strict=True)
            runner = make_runner(ground, effects, values, pair.subject)
            if runner is not None:
                yield runner

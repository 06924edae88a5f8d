"""A second effect that takes little, beside one that explains the gap, and two
of few parameters in the place of one of dozens.

What one leaves may be well within what the level of the noise may be off, and
still more than chance or the twin's own errors give to another effect: that
another one takes it tells, not how much there is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator, is_dithered
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.measures import EXACT_TO, gains
from brace_drake.selection.null_bootstrap import NullDistribution
from brace_drake.selection.search.candidate import Runner, step
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.screening import line_up, race
from brace_drake.selection.search.shortlist import best_fits, try_refine

# Second effects that are searched, and steps of each.
_PLACES, _STEPS = 3, 5
# A straight way foresees half of what a search takes, or less.
_FORESEEN = 0.5


def try_small_second(
    ground: Ground,
    cards: Sequence[Effect],
    null: NullDistribution,
    say: Callable[[str, float], None],
) -> list[CandidateFit]:
    """The leader with the second effect that takes most, refined.

    None where the leader or that effect is averaged over noise, and its
    replays are no nearer than what is looked for.

    Args:
        ground: At the single effect that explains.
        cards: Second effects.
        null: What noise alone gives.
        say: Progress, shares of this search.

    Returns:
        Fits of those searched, up to that one refined; none where no effect
        takes more than noise would.
    """
    evaluator, leader = ground.evaluator, ground.leader
    if is_dithered(evaluator.twin, leader.uses):
        return []
    runners: list[Runner] = []
    least = _FORESEEN * null.least_gain(1) * evaluator.count
    for i, card in enumerate(cards):
        if is_dithered(evaluator.twin, [(card, ())]):
            continue
        say(f"cause {leader.name}+{card.key}", 0.6 * i / len(cards))
        runners += line_up(ground, card, least)
    bar = ground.excess - least
    best: dict[str, Runner] = {}
    for runner in sorted(runners, key=lambda r: r.promise):
        if runner.promise < bar:
            best.setdefault(runner.card.key, runner)
    searched = list(best.values())[:_PLACES]
    for i, runner in enumerate(searched):
        say(f"cause {runner.fit().name}", 0.6 + 0.1 * i)
        step(ground, runner, _STEPS)
    fits = [f for f in best_fits(searched) if f.is_searched]
    for place, fit in enumerate(fits):
        if fit.excess > bar:
            break
        # One of many parameters may take most and yet no more than it would.
        fits[place] = try_refine(evaluator, fit)
        if fits[place].refined and gains(evaluator, leader, fits[place], null):
            return fits
    return []


def race_fewer(
    evaluator: Evaluator,
    leader: CandidateFit,
    many: CandidateFit,
    cards: Sequence[Effect],
    say: Callable[[str, float], None],
) -> list[Runner]:
    """An effect of few parameters with second ones, where one of dozens that
    shows where it does explains the gap, but may only cover it.

    Args:
        evaluator: Over the fit runs.
        leader: The effect of few parameters.
        many: That of dozens.
        cards: Second effects.
        say: Progress, shares of this search.
    """
    if not leader.is_searched:
        return []
    try:
        ground = Ground(evaluator, leader)
    except BraceError:
        return []
    most = max(many.excess, EXACT_TO * evaluator.count)
    return race(ground, cards, say, most=most, must_explain=True)

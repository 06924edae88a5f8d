"""The search over all causes: a race, contenders, and pairs if need be."""

from __future__ import annotations

from collections.abc import Callable

from brace_drake.effects.registry import effects_for
from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.contenders import best_fits, polish, refine
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.ground import Ground
from brace_drake.gap.screen import race
from brace_drake.gap.second_effect import SecondEffects
from brace_drake.gap.surrogates import NullDistribution, draw_null
from brace_drake.gap.verdict import (
    closed_amplitude,
    has_gap,
    is_almost_near_floor,
    is_exact,
    is_near_floor,
    largest_excess,
)

# A flexible effect has to close about this share of the gap's amplitude.
_HALF = 0.5


def try_causes(
    evaluator: Evaluator,
    nominal: CandidateFit,
    seed: int,
    say: Callable[[str, float], None],
) -> tuple[list[CandidateFit], NullDistribution, bool]:
    """Fits of all causes, of pairs where no single one explains the gap.

    Effects of dozens of parameters are tried only where there is something
    left that no simpler one explains.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        seed: Of the surrogates.
        say: Progress.

    Returns:
        Fits, the contenders among them refined; the null distribution; whether
        the search for second effects ended because it had cost too much.
    """
    cards = list(effects_for(evaluator.twin.device).values())
    simple = [c for c in cards if not c.is_flexible]
    ground = Ground(evaluator, nominal)
    most = largest_excess(evaluator, nominal, 1)
    runners = race(ground, simple, _part(say, 0.1, 0.4), most=most)
    say("contenders", 0.4)
    # Those that explain nothing are not compared to the last digit.
    fits = refine(evaluator, best_fits(runners), nominal.excess, rivals=most)
    fits = polish(ground, fits, most)
    null = draw_null(evaluator, nominal, fits, seed)

    def is_done():
        done = is_near_floor(evaluator, fits, null.misfit_threshold)
        # In what surrogates leave too there is nothing for a second effect.
        return done or not (fits and has_gap(evaluator, nominal, fits, null))

    if is_exact(evaluator, nominal):
        return fits, null, False
    second = SecondEffects(ground, fits, runners, null)
    if not is_done() and second.try_pairs(_part(say, 0.45, 0.55)):
        return [*fits, *second.search([], say)], null, False
    flexible = []
    if not is_near_floor(evaluator, fits, null.misfit_threshold):
        cards = [c for c in cards if c.is_flexible]
        more = race(ground, cards, _part(say, 0.55, 0.6), places=0)
        flexible = _refine_flexible(evaluator, nominal, best_fits(more))
        fits += flexible
    if not is_done():
        found = second.search(flexible, _part(say, 0.6, 0.78))
        return [*fits, *found], null, second.is_cut
    return fits, null, False


def _refine_flexible(evaluator, nominal, flexible) -> list[CandidateFit]:
    """Flexible fits, refined where they are near the floor and close about
    half of the gap.

    With so much freedom less is no sign of them, and the end of their search
    is dear. Who leaves more may have another effect beside.
    """
    good, rest = [], []
    for fit in flexible:
        closed = closed_amplitude(evaluator, nominal, fit)
        is_near = is_almost_near_floor(evaluator, fit)
        (good if closed >= _HALF and is_near else rest).append(fit)
    return [*refine(evaluator, good, nominal.excess), *rest]


def _part(say, begin: float, end: float):
    return lambda what, share: say(what, begin + (end - begin) * share)

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
    has_gap,
    is_exact,
    is_near_floor,
    largest_excess,
)

# A flexible effect has to leave less than half of the gap, and may leave so
# many times what the best has left.
_HALF, _BEHIND = 0.5, 2.0


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

    if not is_exact(evaluator, nominal) and not is_near_floor(
        evaluator, fits, null.misfit_threshold
    ):
        flexible = [c for c in cards if c.is_flexible]
        more = race(ground, flexible, _part(say, 0.45, 0.5), places=0)
        fits += _refine_flexible(evaluator, nominal, fits, best_fits(more))
        runners += more
    has_one = fits and has_gap(evaluator, nominal, fits, null)
    # In what surrogates leave too there is nothing for a second effect.
    if has_one and not is_near_floor(evaluator, fits, null.misfit_threshold):
        second = SecondEffects(ground, fits, runners, null)
        fits = [*fits, *second.search(_part(say, 0.55, 0.78))]
        return fits, null, second.is_cut
    return fits, null, False


def _refine_flexible(evaluator, nominal, fits, flexible) -> list[CandidateFit]:
    """Flexible fits, refined where they lead or may come to explain the gap.

    With so much freedom they have to leave less than half of it; a race leaves
    their search far from its end.
    """
    best = min((f.excess for f in fits), default=nominal.excess)
    most = largest_excess(evaluator, nominal, 1)
    bar = min(_HALF * nominal.excess, max(best, min(_BEHIND * best, most)))
    good = [f for f in flexible if f.excess < bar]
    rest = [f for f in flexible if f.excess >= bar]
    return [*refine(evaluator, good, nominal.excess), *rest]


def _part(say, begin: float, end: float):
    return lambda what, share: say(what, begin + (end - begin) * share)

"""The search over all causes: a race, contenders, and pairs if need be."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import effects_for
from brace_drake.errors import BraceError
from brace_drake.gap.candidates import CandidateFit, fit_effects
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.ground import Ground
from brace_drake.gap.pairs import search_pairs
from brace_drake.gap.screen import Runner, make_runner, race, step
from brace_drake.gap.surrogates import NullDistribution, draw_null
from brace_drake.gap.verdict import (
    closed_amplitude,
    explains,
    has_gap,
    is_exact,
    is_near_floor,
    refined,
)

# A rival that leaves this many times what the leader leaves is out.
_CONTENDER = 1.5
_MAX_CONTENDERS = 3
# Other values of discrete parameters that are searched for the best, and how
# far.
_OTHERS, _STEPS = 2, 4
# A second effect is looked for beside one that explains about half the gap.
_HALF = 0.5
# A flexible effect may leave this many times what the best has left.
_UNFINISHED = 2.0
# Who leaves more than this share of what there was has gained nothing.
_NO_GAIN = 0.9
# Of the floor's mean square: about as near as a coarse search comes.
_COARSE = 0.03


def try_causes(
    evaluator: Evaluator,
    nominal: CandidateFit,
    seed: int,
    say: Callable[[str, float], None],
) -> tuple[list[CandidateFit], NullDistribution]:
    """Fits of all causes, of pairs where no single one explains the gap.

    Effects of dozens of parameters are tried only where there is something
    left that no simpler one explains.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        seed: Of the surrogates.
        say: Progress.

    Returns:
        Fits, the contenders among them refined, and the null distribution.
    """
    cards = list(effects_for(evaluator.twin.device).values())
    simple = [c for c in cards if not is_flexible(c)]
    ground = Ground(evaluator, nominal)
    runners = race(ground, simple, _part(say, 0.1, 0.4))
    say("contenders", 0.4)
    fits = _polish(
        ground, refine(evaluator, best_fits(runners), nominal.excess)
    )
    null = draw_null(evaluator, nominal, fits, seed)

    def is_settled(candidates):
        return any(
            explains(evaluator, nominal, f, null) for f in refined(candidates)
        )

    if not is_exact(evaluator, nominal) and not is_near_floor(
        evaluator, fits, null.misfit_threshold
    ):
        flexible = [c for c in cards if is_flexible(c)]
        more = race(ground, flexible, _part(say, 0.45, 0.5), places=0)
        fits += _refine_flexible(evaluator, nominal, fits, best_fits(more))
        runners += more
    has_one = fits and has_gap(evaluator, nominal, fits, null)
    if has_one and not (is_settled(fits) and is_near_floor(evaluator, fits)):
        fits = [*fits, *_try_pairs(ground, fits, runners, is_settled, say)]
    return fits, null


def _try_pairs(ground, fits, runners, is_settled, say) -> list[CandidateFit]:
    """Pairs, refined, where no single effect explains all that there is.

    Where one explains most, two must leave much less to be worth it.
    """
    evaluator, nominal = ground.evaluator, ground.leader
    bar = np.inf
    if is_settled(fits):
        # As the race has left them: then all are equally unfinished.
        bar = _HALF * min(f.excess for f in best_fits(runners))
    partners = _partners(runners, fits, nominal)
    found = search_pairs(ground, partners, _part(say, 0.55, 0.68), bar)
    good = [f for f in best_fits(found) if f.excess <= bar]
    pairs = refine(evaluator, good, nominal.excess)
    if not is_settled([*fits, *pairs]):
        say("a second effect", 0.7)
        cards = [r.problem.effects[0] for r in runners]
        simple = {c.key: c for c in cards if not is_flexible(c)}
        say_more = _part(say, 0.7, 0.78)
        pairs += _beside_best(
            evaluator, nominal, fits, list(simple.values()), say_more
        )
    return refined(pairs)


def _refine_flexible(evaluator, nominal, fits, flexible) -> list[CandidateFit]:
    """Flexible fits, refined where they may come to explain the gap.

    With so much freedom they have to leave less than half of it; a race leaves
    their search far from its end.
    """
    best = min((f.excess for f in fits), default=nominal.excess)
    bar = min(_HALF * nominal.excess, _UNFINISHED * best)
    good = [f for f in flexible if f.excess < bar]
    rest = [f for f in flexible if f.excess >= bar]
    return [*refine(evaluator, good, nominal.excess), *rest]


def _partners(runners, fits, nominal) -> list[Runner]:
    """Who may be one of two effects.

    Beside dozens of parameters any other effect looks right, unless they are
    what explains most.
    """
    leading = next(iter(refined(fits)), nominal).name
    cards = [r.problem.effects[0] for r in runners]
    return [
        runner
        for runner, card in zip(runners, cards, strict=True)
        if not is_flexible(card) or card.key == leading
    ]


def _beside_best(evaluator, nominal, fits, cards, say) -> list[CandidateFit]:
    """Second effects beside the best single one, where it explains much.

    Two effects need not look like the sum of their small selves.
    """
    leader = min(fits, key=lambda f: (not f.refined, f.excess))
    if closed_amplitude(evaluator, nominal, leader) < _HALF:
        return []
    others = [c for c in cards if c.name not in leader.identifiers]
    more = race(Ground(evaluator, leader), others, say)
    return refine(evaluator, best_fits(more), leader.excess)


def is_flexible(card: Effect) -> bool:
    """Whether a card has parameters by the dozen, held by priors."""
    return card.spread is not None or bool(card.run_parameters)


def best_fits(runners: Sequence[Runner]) -> list[CandidateFit]:
    """One fit for each candidate, best first."""
    fits = sorted((r.fit() for r in runners), key=lambda f: f.excess)
    searched = {f.name for f in fits if f.solution.jacobian is not None}
    best: dict[str, CandidateFit] = {}
    for fit in fits:
        if fit.name not in searched or fit.solution.jacobian is not None:
            best.setdefault(fit.name, fit)
    return list(best.values())


def refine(
    evaluator: Evaluator, fits: Sequence[CandidateFit], there: float
) -> list[CandidateFit]:
    """Leads the search of the contenders to its end, best first.

    Args:
        evaluator: Over the fit runs.
        fits: From a race.
        there: Excess of the fit that the race set out from; who takes next to
            nothing of it is no contender, unless he is the best.
    """
    out = []
    ranked = sorted(fits, key=lambda f: f.excess)
    # Rivals are compared as the race has left them, all alike unfinished.
    bar = (
        _bar(ranked[0].excess, there, _COARSE * evaluator.count) if fits else 0
    )
    for place, fit in enumerate(ranked):
        searched = fit.solution.jacobian is not None and not fit.refined
        if place < _MAX_CONTENDERS and searched:
            if place == 0 or fit.excess <= bar:
                fit = _try_refine(evaluator, fit)
        out.append(fit)
    return out


def _bar(least: float, there: float, trust: float) -> float:
    """Excess up to which a fit is a contender."""
    return min(_NO_GAIN * there - trust, _CONTENDER * max(trust, least + trust))


def other_choices(ground: Ground, fit: CandidateFit) -> list[Runner]:
    """The fit with its last effect's discrete parameters at other values."""
    card, found = fit.effects[-1], []
    mine = fit.values[-1][: len(card.parameters)]
    discrete = [p.choices for p in card.parameters if p.choices]
    for choice in itertools.product(*discrete):
        values = mine.copy()
        values[~card.is_continuous] = choice
        if np.array_equal(values, mine):
            continue
        runner = make_runner(
            ground, fit.effects, [*fit.values[:-1], values], fit.subject
        )
        if runner is not None:
            found.append(runner)
    found.sort(key=lambda r: r.residual @ r.residual)
    for runner in found[:_OTHERS]:
        step(ground, runner, _STEPS)
    return found[:_OTHERS]


def _polish(ground, fits):
    """Tries other discrete parameters of the best fit, where it has any."""
    best = next(iter(refined(fits)), None)
    if best is None:
        return fits
    if is_flexible(best.effects[-1]) or is_exact(ground.evaluator, best):
        return fits
    for runner in other_choices(ground, best):
        other = runner.fit()
        if other.solution.jacobian is not None and other.excess < best.excess:
            other = _try_refine(ground.evaluator, other)
        if other.refined and other.excess < best.excess:
            fits = [other if f is best else f for f in fits]
            best = other
    return fits


def _try_refine(evaluator, fit):
    try:
        return fit_effects(evaluator, fit.effects, fit)
    except (BraceError, ValueError):
        # A candidate whose twin cannot even run explains nothing.
        return fit


def _part(say, begin: float, end: float):
    return lambda what, share: say(what, begin + (end - begin) * share)

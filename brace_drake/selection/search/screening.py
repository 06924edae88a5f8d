"""A race of causes: one replay for all, a search for who promises most."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.selection.search.candidate import Runner, make_runner, step
from brace_drake.selection.search.linearisation import Ground

_STEPS = 5
# Rounds of so many steps, as long as one leaves less than this share of what
# the one before has left.
_ROUNDS, _WORTH_A_ROUND = 4, 0.7
# What a round leaves of what the one before has left, where it goes well; and
# the first one, which may have begun far behind the leader, at the very best.
_GOOD_ROUND, _BEST_ROUND = 0.5, 0.1
# A round that leaves what was promised, so near, has come to its end.
_AS_PROMISED = 0.02
# Of what a search leaves, a promise of less than this share was not kept.
_BROKEN = 0.5
# Who is searched: this many, and all that promise to leave at most this many
# times what the best has left so far.
_PLACES, _FACTOR = 5, 2.0
# So many are enough once one follows the recording to the floor.
_PLACES_AT_FLOOR = 3
# Beyond these places a promise counts from this share of the gap on.
_SHARE = 0.1
# About as near as a coarse search comes, in squares of the floor; over dozens
# of parameters the last of it is left to the end of the search.
_COARSE, _COARSE_OF_MANY = 0.01, 0.5
# A start is tried again at another strength, this often, where it is more than
# that many times too strong or too weak.
_RESCALED, _ENOUGH, _WEAKEST = 2, 0.4, 0.05
# One straight way foresees about half of what a search takes, or less: it
# knows of one mixture of parameters, and of no bend in what the subject's do;
# nor does a first step know a breath whose rate is not yet right.
_BENDS = 2.0
# Of more parameters than this one straight way says nothing.
_FEW_WAYS = 4
# A start that promises to leave this share of the gap is not tried again; and
# beyond so many places not searched.
_HOPELESS, _HOPELESS_PLACES = 0.98, 2


def race(
    ground: Ground,
    cards: Sequence[Effect],
    say=lambda what, share: None,
    places: int = _PLACES,
    bar: float = np.inf,
    most: float = np.inf,
    must_explain: bool = False,
    least: float = np.inf,
) -> list[Runner]:
    """Runs the leader's effects with each of the cards, at each start.

    Args:
        ground: Where to set out from.
        cards: One effect each.
        say: Progress.
        places: So many are searched whatever they promise.
        bar: Of effects of dozens of parameters that are drawn alike who
            promises to leave more is not searched, of others who promises to
            leave by far more.
        most, must_explain, least: See `search_best`.

    Returns:
        Runners, those searched with a Jacobian; none is searched where the
        leader leaves nothing to explain.
    """
    runners = []
    leader = f"{ground.leader.name}+" if ground.leader.effects else ""
    for i, card in enumerate(cards):
        say(f"cause {leader}{card.key}", 0.6 * i / len(cards))
        runners += line_up(ground, card)
    if ground.is_exact:
        return runners
    best: dict[str, list[Runner]] = {}
    for runner in sorted(runners, key=lambda r: r.promise):
        best.setdefault(runner.card.key, []).append(runner)
    good = []
    for first, *more in best.values():
        if first.promise <= _highest(bar, first.card):
            first.others = _from_other_start(first, more)
            good.append(first)
    search_best(ground, good, say, places, most, must_explain, least)
    return runners


def _from_other_start(
    first: Runner, more: Sequence[Runner]
) -> tuple[Runner, ...]:
    """The best one from another start, of an effect of few parameters: from
    one time constant, or one width of a loop, no way may lead to another.
    """
    if first.card.is_flexible:
        return ()
    others = (r for r in more if r.start != first.start)
    return tuple(itertools.islice(others, 1))


def _excess(ground: Ground, runner: Runner) -> float:
    """Sum of squares above noise where a search stands; with what the leader's
    parameters cost, where that counts.
    """
    mine = runner.residual[: ground.rows]
    noise = ground.noise + ground.added_noise(runner.problem, runner.z)
    return float(mine @ mine) - noise


def _highest(bar: float, card: Effect) -> float:
    """The promise from which a card may come below the bar."""
    return bar if card.spread is not None else _BENDS * bar


def search_best(
    ground: Ground,
    runners: Sequence[Runner],
    say=lambda what, share: None,
    places: int = _PLACES,
    most: float = np.inf,
    must_explain: bool = False,
    least: float = np.inf,
) -> None:
    """Searches the runners that promise most, best first.

    Args:
        ground: Where they set out from.
        runners: By what they promise.
        say: Progress.
        places: So many are searched whatever they promise.
        most: Who promises to leave more and has strayed behind the leader is
            not led back.
        must_explain: Whether who will not come below that is of no use: he is
            given up, and who promises next to no gain is not searched.
        least: Excess that another one has left before.
    """
    trust = _COARSE * ground.evaluator.count
    there = ground.there
    for place, runner in enumerate(runners):
        fit = runner.fit()
        far_behind = fit.excess > _FACTOR * (least + trust)
        no_gain = there - fit.excess < max(trust, _SHARE * there)
        if least <= trust:
            places = min(places, _PLACES_AT_FLOOR)
        if place >= places and (far_behind or no_gain):
            break
        if no_gain and must_explain:
            break
        if place >= _HOPELESS_PLACES and fit.excess > _HOPELESS * there:
            break
        say(f"cause {fit.name}", 0.6 + 0.4 * place / len(runners))
        for start in (runner, *runner.others):
            if _search(ground, start, least, trust, most, must_explain):
                least = max(0.0, min(least, start.fit().excess))
            # Where one has come to the floor no other way need be tried.
            if least <= trust:
                break


def _search(
    ground: Ground,
    runner: Runner,
    least: float,
    trust: float,
    most: float,
    must_explain: bool,
) -> bool:
    """Rounds of steps while they bring much; False if its twin breaks down.

    Who would not come near the best at the rate of the last round gives up.
    """
    before, promise = np.inf, runner.promise
    is_hopeless, enough = promise > most, trust
    if runner.card.spread is not None:
        enough = _COARSE_OF_MANY * ground.evaluator.count
    for done in range(1, _ROUNDS + 1):
        if not step(ground, runner, _STEPS):
            return False
        left = runner.fit().excess
        rate = left / before
        is_lost = is_hopeless and left > ground.there
        if left < enough or rate > _WORTH_A_ROUND or is_lost:
            break
        is_first, rounds = done == 1, _ROUNDS - done
        if is_first and np.isclose(left, promise, rtol=_AS_PROMISED):
            break
        hoped = left * (_GOOD_ROUND if is_first else rate) ** rounds
        if must_explain and hoped > most:
            break
        if is_first:
            hoped = left * _BEST_ROUND**rounds
        if hoped > _FACTOR * (least + trust):
            break
        before = left
    could_lead = promise < _FACTOR * (least + trust)
    is_broken = enough < left and promise < _BROKEN * left
    has_strayed = must_explain and left > ground.there
    if could_lead and is_broken and not (is_lost or has_strayed):
        # Far from the leader his sensitivities may lead nowhere.
        return step(ground, runner, _STEPS, own=True)
    return True


def line_up(
    ground: Ground, card: Effect, least: float | None = None
) -> list[Runner]:
    """The card beside the leader's effects, at each of its starts.

    A start that is far too strong or too weak, or of the wrong sign, is
    followed by one of the strength that it foresees.

    Args:
        ground: Where to set out from.
        card: The effect.
        least: What a start has to promise to take for that; as a rule some
            of what there is, and nothing is tried twice beside a leader that
            leaves nothing.
    """
    leader, found = ground.leader, []
    for values in card.starts():
        start = tuple(values[card.has_several_starts])
        for _ in range(_RESCALED + 1):
            runner = make_runner(
                ground,
                [*leader.effects, card],
                [*leader.values, values],
                leader.subject,
                leader.spread,
                card,
            )
            if runner is None:
                break
            runner.start = start
            runner.promise, far = ground.foresee(
                runner.problem, runner.z, runner.residual, card.has_either_sign
            )
            found.append(runner)
            if card.is_continuous.sum() > _FEW_WAYS:
                if step(ground, runner, 1):
                    runner.promise = _excess(ground, runner)
                break
            if card.run_parameters or _ENOUGH < far < 1.0 / _ENOUGH:
                break
            if least is None and ground.is_exact:
                return found
            if _is_hopeless(ground, runner.promise, least):
                break
            factor = np.copysign(max(abs(far), _WEAKEST), far)
            rescaled = card.scaled(values, factor)
            if np.allclose(rescaled, values, rtol=0.1, atol=0.0):
                break
            values = rescaled
    return found


def _is_hopeless(ground: Ground, promise: float, least: float | None) -> bool:
    if least is None:
        return promise > _HOPELESS * ground.there
    return promise > ground.excess - least

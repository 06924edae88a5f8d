"""A race of causes: one replay for all, a search for who promises most.

Everything is simulated at the coarse plant step, with the sensitivities of
the subject (and of the effects that are there already) kept from the fit that
the race sets out from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.errors import BraceError
from brace_drake.fit.gauss_newton import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.gap.candidates import CandidateFit, finish_fit
from brace_drake.gap.ground import Ground
from brace_drake.gap.problem import CandidateProblem

_STEPS = 5
# Rounds of so many steps, as long as one leaves less than this share of what
# the one before has left.
_ROUNDS, _WORTH_A_ROUND = 4, 0.7
# What a round leaves of what the one before has left, where it goes well.
_GOOD_ROUND = 0.5
# Of what a search leaves, a promise of less than this share was not kept.
_BROKEN = 0.5
# Who is searched: this many, and all that promise to leave at most this many
# times what the best has left so far.
_PLACES, _FACTOR = 5, 2.0
# So many are enough once one follows the recording to the floor.
_PLACES_AT_FLOOR = 3
# Beyond these places a promise counts from this share of the gap on.
_SHARE = 0.1
# About as near as a coarse search comes, in squares of the floor.
_COARSE = 0.01
# A start is tried again at another strength, this often, where it is more than
# that many times too strong or too weak.
_RESCALED, _ENOUGH, _WEAKEST = 2, 0.4, 0.05
# A start that promises to leave this share of the gap is not tried again.
_HOPELESS = 0.98
# Relative decrease of the sum of squares that ends a round. Where drives stick
# less is chance; of dozens of parameters each step is dear.
_END, _END_ROUGH = 1e-3, 1e-2
# Beyond this many parameters the Jacobian is differenced once.
_FEW = 8


@dataclass
class Runner:
    """A cause in the race: where its search stands, and what it promises.

    Attributes:
        problem: Its parameters.
        z: Where it stands.
        residual: There, prior rows below.
        jacobian: Of its last step.
        promise: Sum of squares above noise that it is foreseen to leave.
    """

    problem: CandidateProblem
    z: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray | None = None
    promise: float = np.inf

    @property
    def card(self) -> Effect:
        """The effect that it has beside the leader's."""
        return self.problem.effects[-1]

    def fit(self) -> CandidateFit:
        """Where it stands as a fit; not yet searched, as it promises."""
        solution = LeastSquaresSolution(
            self.z, self.residual, self.jacobian, 0, False
        )
        fit = finish_fit(self.problem, solution, coarse=True)
        if self.jacobian is not None:
            return fit
        return replace(fit, excess=float(self.promise))


def race(
    ground: Ground,
    cards: Sequence[Effect],
    say=lambda what, share: None,
    places: int = _PLACES,
    bar: float = np.inf,
    most: float = np.inf,
    must_explain: bool = False,
) -> list[Runner]:
    """Runs the leader's effects with each of the cards, at each start.

    Args:
        ground: Where to set out from.
        cards: One effect each.
        say: Progress.
        places: So many are searched whatever they promise.
        bar: Who promises to leave more is not searched.
        most, must_explain: See `search_best`.

    Returns:
        Runners, those searched with a Jacobian; none is searched where the
        leader leaves nothing to explain.
    """
    runners = []
    for i, card in enumerate(cards):
        say(f"cause {card.key}", 0.6 * i / len(cards))
        runners += line_up(ground, card)
    if ground.is_exact:
        return runners
    best = {}
    for runner in sorted(runners, key=lambda r: r.promise):
        best.setdefault(runner.card.key, runner)
    good = [r for r in best.values() if r.promise <= bar]
    search_best(ground, good, say, places, most, must_explain)
    return runners


def search_best(
    ground: Ground,
    runners: Sequence[Runner],
    say=lambda what, share: None,
    places: int = _PLACES,
    most: float = np.inf,
    must_explain: bool = False,
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
    """
    least, trust = np.inf, _COARSE * ground.evaluator.count
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
        say(f"cause {fit.name}", 0.6 + 0.4 * place / len(runners))
        if _search(ground, runner, least, trust, most, must_explain):
            least = max(0.0, min(least, runner.fit().excess))


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
    before, is_hopeless = np.inf, runner.promise > most
    for done in range(1, _ROUNDS + 1):
        if not step(ground, runner, _STEPS):
            return False
        left = runner.fit().excess
        rate = left / before
        is_lost = is_hopeless and left > ground.there
        if left < trust or rate > _WORTH_A_ROUND or is_lost:
            break
        # The first round may have begun far behind the leader.
        is_first = done == 1
        hoped = left * (_GOOD_ROUND if is_first else rate) ** (_ROUNDS - done)
        if must_explain and hoped > most:
            break
        if not is_first and hoped > _FACTOR * (least + trust):
            break
        before = left
    could_lead = runner.promise < _FACTOR * (least + trust)
    is_broken = trust < left and runner.promise < _BROKEN * left
    has_strayed = must_explain and left > ground.there
    if could_lead and is_broken and not (is_lost or has_strayed):
        # Far from the leader his sensitivities may lead nowhere.
        return step(ground, runner, _STEPS, own=True)
    return True


def step(ground: Ground, runner: Runner, count: int, own: bool = False) -> bool:
    """Steps of a search; False where its twin breaks down.

    With sensitivities of the leader's parameters that are the leader's, or
    `own` ones of where the search is, as an effect of dozens of parameters
    always has: it goes far from the leader.
    """
    problem = runner.problem
    always = runner.card.spread is not None
    differentiate = ground.differentiate(problem)
    if own or always:
        differentiate = partial(_differentiate, problem)
    is_rough = problem.is_rough or problem.has_spread
    keeps = problem.num_free > _FEW and (always or not own)
    kept = runner.jacobian if keeps else None
    try:
        solution = solve_gauss_newton(
            partial(problem.batch, coarse=True),
            runner.z,
            problem.lower,
            problem.upper,
            problem.steps,
            problem.radius,
            differentiate=differentiate,
            known=(runner.residual, kept),
            max_iterations=count,
            tolerance=_END_ROUGH if is_rough else _END,
        )
    except (BraceError, ValueError, np.linalg.LinAlgError):
        return False
    runner.z, runner.residual = solution.z, solution.residual
    runner.jacobian = solution.jacobian
    return True


def _differentiate(problem: CandidateProblem, z, residual):
    return problem.columns(z, base=residual)


def line_up(ground: Ground, card: Effect) -> list[Runner]:
    """The card beside the leader's effects, at each of its starts.

    A start that is far too strong or too weak, or of the wrong sign, is
    followed by one of the strength that it foresees.
    """
    leader, found = ground.leader, []
    for values in card.starts():
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
            runner.promise, far = ground.foresee(
                runner.problem, runner.z, runner.residual, card.has_either_sign
            )
            found.append(runner)
            if card.spread is not None:
                # The way to no error at all says nothing.
                if step(ground, runner, 1):
                    runner.promise = runner.fit().excess
                break
            if card.run_parameters or _ENOUGH < far < 1.0 / _ENOUGH:
                break
            if ground.is_exact:
                return found
            if runner.promise > _HOPELESS * ground.there:
                break
            factor = np.copysign(max(abs(far), _WEAKEST), far)
            rescaled = card.scaled(values, factor)
            if np.allclose(rescaled, values, rtol=0.1, atol=0.0):
                break
            values = rescaled
    return found


def make_runner(
    ground: Ground,
    effects: Sequence[Effect],
    values: Sequence[np.ndarray],
    subject: np.ndarray,
    spread: float | None = None,
    fresh: Effect | None = None,
) -> Runner | None:
    """A candidate where its search begins; None where its twin breaks down.

    Args:
        ground: Where the race sets out from.
        effects: Of the candidate, the leader's first.
        values: Parameters of each.
        subject: Values of the subject's parameters.
        spread: Of parameters that have a common one, where it is known.
        fresh: An effect whose runs take the best of their own starts.
    """
    problem = CandidateProblem(ground.evaluator, effects, values)
    if spread is not None:
        problem.spread = spread / problem.spread_scale
    z = problem.join(subject, values)
    if fresh is not None:
        z, residual = own_starts(problem, fresh, z)
    else:
        (residual,) = problem.batch([z], coarse=True)
    return None if residual is None else Runner(problem, z, residual)


def own_starts(problem: CandidateProblem, card: Effect, z: np.ndarray):
    """Residual at z, every run at the best of its own starts."""
    points = problem.run_starts(z, card)
    found = problem.batch(points, coarse=True)
    if len(points) == 1:
        return z, found[0]
    ends = problem.evaluator.ends
    kept = [(p, r) for p, r in zip(points, found, strict=True) if r is not None]
    if not kept:
        return z, None
    out, residual = z.copy(), kept[0][1].copy()
    for run, (begin, end) in enumerate(zip([0, *ends], ends, strict=False)):
        costs = [r[begin:end] @ r[begin:end] for _, r in kept]
        point, chosen = kept[int(np.argmin(costs))]
        residual[begin:end] = chosen[begin:end]
        mine = problem.places_in_run(card, run)
        out[mine] = point[mine]
    return out, residual

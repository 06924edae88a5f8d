"""A candidate on its way: where its search stands, and a step of it.

Everything is simulated at the coarse plant step, with the sensitivities of
the subject (and of the effects that are there already) kept from the fit that
the search sets out from, unless told otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit, finish_fit
from brace_drake.identification.gauss_newton import (
    LeastSquaresSolution,
    solve_gauss_newton,
)
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection.search.linearisation import Ground

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
        start: Where parameters of several starts began.
        others: The same cause from another start, best first.
    """

    problem: CandidateProblem
    z: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray | None = None
    promise: float = np.inf
    start: tuple[float, ...] = ()
    others: tuple[Runner, ...] = ()

    @property
    def card(self) -> Effect:
        """The effect that it has beside the leader's."""
        return self.problem.effects[-1]

    @property
    def excess(self) -> float:
        """Sum of squares above noise where it stands, searched or not."""
        return self._stand().excess

    def fit(self) -> CandidateFit:
        """Where it stands as a fit; not yet searched, as it promises."""
        fit = self._stand()
        if self.jacobian is not None:
            return fit
        return replace(fit, excess=float(self.promise))

    def _stand(self) -> CandidateFit:
        solution = LeastSquaresSolution(
            self.z, self.residual, self.jacobian, 0, False
        )
        return finish_fit(self.problem, solution, coarse=True)


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
        spread: Of parameters that have a common one, where it is known; of
            no account where none of the effects has any.
        fresh: An effect whose runs take the best of their own starts.
    """
    problem = CandidateProblem(ground.evaluator, effects, values)
    if spread is not None and problem.has_spread:
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

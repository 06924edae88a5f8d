"""A push of one subject by any controller, on compiled laws, without chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.core.parallel import Workers
from brace_drake.experiments.scores import FAILED, Push, Score, score_push
from brace_drake.learning.compiled_loop import CompiledLoop
from brace_drake.learning.episode import PreparedTask
from brace_drake.learning.policy import Policy
from brace_drake.learning.rewards import calc_reward, find_violation
from brace_drake.learning.signals import Signals, stack_signals
from brace_drake.learning.subjects import Subject
from brace_drake.learning.task import LearningTask
from brace_drake.scenario.brace import BraceScenario

# Samples between two decisions: 5 ms where the paper decides every 50 ms.
SAMPLES = 10
# Of the range, on a linear scale: nearer than this counts as its end.
_AT_BOUND = 0.01


@dataclass(frozen=True)
class Controller:
    """The scenario's own controller of a tag, a constant, or a policy.

    Attributes:
        name: Of all seeds together.
        tag: Of the controller.
        stiffness: K_d of the impedance throughout, N/m; None: the scenario's.
        policy: Sets the stiffness of a `vpic`.
        seed: Of the policy's training.
    """

    name: str
    tag: str = "pic"
    stiffness: float | None = None
    policy: Policy | None = None
    seed: int = 0


@dataclass(frozen=True)
class Rollout:
    """What happened, N samples; nothing is cut off at a limit.

    A push that has failed ends there, at worst before its first sample.

    Attributes:
        time: (N,), s.
        signals: The truth (N, 6n).
        stiffness: In use, of coordinates with an impedance (N, k), N/m; 0
            where a controller has none.
        total: Return of the task's reward, at its decisions; -inf of a push
            that has failed.
        cause: The first limit of the task that was passed, or the failure of
            the simulation; "" where all went well.
    """

    time: np.ndarray
    signals: Signals
    stiffness: np.ndarray
    total: float
    cause: str

    @property
    def failed(self) -> bool:
        """Whether the simulation has."""
        return self.total == -np.inf


@dataclass(frozen=True)
class TaskScore(Score):
    """A push measured by its task too.

    Of a push that has failed errors and forces are infinite, and there is no
    stiffness (nan).

    Attributes:
        at_upper: Whether the mean stiffness is at the upper end of its range.
        total: Return.
        over_force: Whether the force passed F_max of the reward.
        broke: Whether a limit that ends an episode was passed, or worse.
    """

    at_upper: bool
    total: float
    over_force: bool
    broke: bool

    @property
    def violates(self) -> bool:
        """Whether F_max or a limit was passed."""
        return self.over_force or self.broke


class Benchmark(PreparedTask):
    """A task on which controllers are compared, with exact readings.

    Args:
        task: Its ranges say what effects a subject's numbers are of.
        scenario: In place of the task's own.

    Raises:
        ScenarioError: Task or scenario are not allowed.
    """

    def __init__(
        self, task: LearningTask, scenario: BraceScenario | None = None
    ):
        exact = replace(task, readings="exact", backend="compiled")
        super().__init__(exact, scenario)

    @property
    def pushed(self) -> int:
        """Index of the coordinate that goes furthest."""
        return int(np.argmax(np.abs(self.task.displacement)))

    @property
    def force_limit(self) -> float:
        """F_max of the reward along the push, N."""
        return float(self.task.reward.force_limit[self.pushed])

    def run(self, controller: Controller, subject: Subject) -> Rollout:
        """Runs a subject's whole push."""
        task, policy = self.task, controller.policy
        loop = CompiledLoop(
            self._scenario_of(controller),
            task.sample_time / SAMPLES,
            task.motion_time,
        )
        episode = self.draw(np.random.default_rng(0), subject)
        held = self.law.action(self.law.start)
        asked = np.empty(0) if policy is None else self.stiffness(held)
        samples, used, total, cause = [], [], 0.0, ""
        try:
            loop.start(episode, asked)
            before = self._share(loop, policy, held)
            for _ in range(task.max_steps):
                if policy is not None:
                    action = policy.act_on(loop.estimate, loop.desired)
                    held = policy.law.limit(action, held)
                    asked[self.selected] = policy.law.stiffness(held)
                for _ in range(SAMPLES):
                    loop.advance(asked)
                    samples.append(loop.truth())
                    used.append(loop.stiffness[self.selected].copy())
                now = self._share(loop, policy, held)
                terms = calc_reward(samples[-1], now - before, task.reward)
                before, total = now, total + sum(terms.values())
                cause = cause or find_violation(
                    samples[-1], task.limits, self.scenario.rings
                )
        except BraceError as error:
            cause, total = cause or f"failed: {error}", -np.inf
        return Rollout(
            time=task.sample_time / SAMPLES * np.arange(1, len(samples) + 1),
            signals=stack_signals(samples, len(self.selected)),
            stiffness=np.reshape(used, (-1, int(self.selected.sum()))),
            total=total,
            cause=cause,
        )

    def score(self, rollout: Rollout) -> TaskScore:
        """Measures of a push."""
        if rollout.failed:
            return TaskScore(*vars(FAILED).values(), False, -np.inf, True, True)
        i, signals = self.pushed, rollout.signals
        base = 6 * (i // 6)
        error = signals.desired - signals.position
        push = Push(
            rollout.time,
            error[:, [i, base, base + 2]],
            signals.desired_rate[:, i] - signals.rate[:, i],
            signals.force[:, i],
            rollout.stiffness[:, int(self.selected[:i].sum())],
        )
        found, law = score_push(push), self.law
        slack = _AT_BOUND * (law.upper - law.lower)
        return TaskScore(
            **vars(found),
            at_upper=law.upper - found.stiffness < slack,
            total=rollout.total,
            over_force=found.peak_force > self.force_limit,
            broke=bool(rollout.cause),
        )

    def run_and_score(
        self, controller: Controller, subject: Subject
    ) -> TaskScore:
        """The measures of one push."""
        return self.score(self.run(controller, subject))

    def _scenario_of(self, controller: Controller):
        control = self.scenario.control
        tag = "vpic" if controller.policy is not None else controller.tag
        control = replace(control, tag=tag)
        if controller.stiffness is not None:
            size = np.shape(control.impedance.stiffness)
            stiffness = np.full(size, controller.stiffness)
            impedance = replace(control.impedance, stiffness=stiffness)
            control = replace(control, impedance=impedance)
        return replace(self.scenario, control=control)

    def _share(self, loop: CompiledLoop, policy, held) -> np.ndarray:
        """Where the stiffness is within its range, 0 to 1."""
        law = self.law
        if policy is None:
            used = np.clip(loop.stiffness[self.selected], law.lower, law.upper)
            held = law.action(used)
        return 0.5 * (held + 1.0)


_GRID = 9
_ROUNDS = 3
_INSIDE = 3
# Nearer than this part of the range, in its logarithm, is the end itself.
_AT_END = 0.01


@dataclass(frozen=True)
class ConstantSearch:
    """A search over one stiffness that is held through the push.

    Attributes:
        best: Of the largest return, N/m.
        total: Mean return with it.
        tried: The grid over the whole range, N/m.
        totals: Mean return of each of these.
        at_upper: Whether the best is the upper end of the range.
    """

    best: float
    total: float
    tried: tuple[float, ...]
    totals: tuple[float, ...]
    at_upper: bool


def search_constant(
    benchmark: Benchmark, subjects: Sequence[Subject], workers: Workers
) -> ConstantSearch:
    """The constant stiffness of PIC with the largest mean return.

    A policy has to beat it. A grid over the range of the policies, even in its
    logarithm, then a finer one between the neighbours of the best, and so on.
    """
    law = benchmark.law
    grid = np.geomspace(law.lower, law.upper, _GRID)

    def mean_returns(values) -> list[float]:
        tasks = [
            (benchmark, Controller("", stiffness=float(K)), subject)
            for K in values
            for subject in subjects
        ]
        flat = np.array(workers.map(_return_of, tasks))
        return flat.reshape((len(values), -1)).mean(axis=1).tolist()

    totals = mean_returns(grid)
    known = dict(zip(grid.tolist(), totals, strict=True))
    for _ in range(_ROUNDS):
        order = sorted(known)
        i = order.index(max(order, key=known.get))
        low, high = order[max(0, i - 1)], order[min(len(order) - 1, i + 1)]
        finer = np.geomspace(low, high, _INSIDE + 2)[1:-1]
        finer = [K for K in finer.tolist() if K not in known]
        known |= dict(zip(finer, mean_returns(finer), strict=True))
    best = max(known, key=known.get)
    span = np.log(law.upper / law.lower)
    return ConstantSearch(
        best=best,
        total=known[best],
        tried=tuple(grid.tolist()),
        totals=tuple(totals),
        at_upper=bool(np.log(law.upper / best) < _AT_END * span),
    )


def _return_of(benchmark, controller: Controller, subject: Subject) -> float:
    return benchmark.run(controller, subject).total

"""A push of one subject by any controller, on compiled laws, without chance."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.learning.compiled_loop import CompiledLoop
from brace_drake.learning.episode import PreparedTask
from brace_drake.learning.policy import Policy
from brace_drake.learning.rewards import calc_reward, find_violation
from brace_drake.learning.signals import Signals, stack_signals
from brace_drake.learning.subjects import Subject
from brace_drake.learning.task import LearningTask

# Samples between two decisions: 5 ms where the paper decides every 50 ms.
SAMPLES = 10


@dataclass(frozen=True)
class Contestant:
    """A controller: the scenario's own of a tag, a constant, or a policy.

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
        desired, desired_rate, position, rate, force: See `Signals`, the truth
            (N, 6n).
        stiffness: In use, of coordinates with an impedance (N, k), N/m; 0
            where a controller has none.
        total: Return of the task's reward, at its decisions; -inf of a push
            that has failed.
        cause: The first limit of the task that was passed, or the failure of
            the simulation; "" where all went well.
        failed: Whether the simulation has.
    """

    time: np.ndarray
    desired: np.ndarray
    desired_rate: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    total: float
    cause: str
    failed: bool = False


class Arena:
    """A task on which controllers meet, with exact readings.

    Args:
        task: Its ranges say what effects a subject's numbers are of.

    Raises:
        ScenarioError: Task or scenario are not allowed.
    """

    def __init__(self, task: LearningTask):
        task = replace(task, readings="exact", backend="compiled")
        self._prepared = prepared = PreparedTask(task)
        self.scenario, self.task = prepared.scenario, prepared.task
        self.law, self.selected = prepared.law, prepared.selected

    @property
    def pushed(self) -> int:
        """Index of the coordinate that goes furthest."""
        return int(np.argmax(np.abs(self.task.displacement)))

    def run(self, contestant: Contestant, subject: Subject) -> Rollout:
        """Runs a subject's whole push."""
        task, policy = self.task, contestant.policy
        loop = CompiledLoop(
            self._scenario_of(contestant),
            task.sample_time / SAMPLES,
            task.motion_time,
        )
        episode = self._prepared.draw(np.random.default_rng(0), subject)
        held = self.law.action(self.law.start)
        asked, samples, used = self._ask(policy, held), [], []
        total, cause, failed = 0.0, "", False
        try:
            loop.start(episode, asked)
            before = self._share(loop, policy, held)
            for _ in range(task.max_steps):
                if policy is not None:
                    action = policy.act_on(loop.estimate, loop.desired)
                    held = policy.law.limit(action, held)
                    asked = self._ask(policy, held)
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
            cause, failed = cause or f"failed: {error}", True
        return self._make_rollout(samples, used, total, cause, failed)

    def _scenario_of(self, contestant: Contestant):
        control = self.scenario.control
        tag = "vpic" if contestant.policy is not None else contestant.tag
        control = replace(control, tag=tag)
        if contestant.stiffness is not None:
            size = np.shape(control.impedance.stiffness)
            stiffness = np.full(size, contestant.stiffness)
            impedance = replace(control.impedance, stiffness=stiffness)
            control = replace(control, impedance=impedance)
        return replace(self.scenario, control=control)

    def _ask(self, policy: Policy | None, held: np.ndarray) -> np.ndarray:
        if policy is None:
            return np.empty(0)
        asked = np.zeros(len(self.selected))
        asked[self.selected] = policy.law.stiffness(held)
        return asked

    def _share(self, loop: CompiledLoop, policy, held) -> np.ndarray:
        """Where the stiffness is within its range, 0 to 1."""
        law = self.law
        if policy is None:
            used = np.clip(loop.stiffness[self.selected], law.lower, law.upper)
            held = law.action(used)
        return 0.5 * (held + 1.0)

    def _make_rollout(
        self,
        samples: list[Signals],
        used: list,
        total: float,
        cause: str,
        failed: bool,
    ) -> Rollout:
        m, k = len(self.selected), int(self.selected.sum())
        step = self.task.sample_time / SAMPLES
        return Rollout(
            time=step * np.arange(1, len(samples) + 1),
            stiffness=np.array(used).reshape(-1, k),
            total=-np.inf if failed else total,
            cause=cause,
            failed=failed,
            **stack_signals(samples, m)._asdict(),
        )

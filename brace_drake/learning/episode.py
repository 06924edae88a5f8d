"""An episode: what it is drawn from, and what a policy did in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import gymnasium
import numpy as np

from brace_drake.effects.stack import Use
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.signals import Signals, stack_signals
from brace_drake.learning.subjects import (
    NOMINAL,
    Subject,
    draw_subject,
    uses_of,
)
from brace_drake.learning.task import (
    LearningTask,
    check_task,
    load_task_scenario,
    make_action_law,
    spread_task,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace
from brace_drake.scenario.control_numbers import parse_coordinates


@dataclass(frozen=True)
class Episode:
    """What a loop is set up with.

    Attributes:
        subject: As drawn.
        numbers: Of the brace with this subject.
        uses: Effects with their parameters.
        way: What the motion adds to the start (6n,).
        draws: Standard normal, at each tick (ticks, 9n + 3), or (0, 9n + 3).
    """

    subject: Subject
    numbers: BraceNumbers
    uses: tuple[Use, ...]
    way: np.ndarray
    draws: np.ndarray


class PreparedTask:
    """A checked task with the numbers of its scenario; episodes are drawn here.

    Attributes:
        task: With arrays of all rings.
        scenario: Of the brace.
        law: From actions to stiffness.
        selected: Coordinates with an impedance (6n,), bool.

    Args:
        task: To be checked.
        scenario: In place of the task's own, as `load_task_scenario` gives it.

    Raises:
        ScenarioError: Task or scenario are not allowed: key, value, range.
    """

    def __init__(
        self, task: LearningTask, scenario: BraceScenario | None = None
    ):
        self.scenario: BraceScenario = scenario or load_task_scenario(task)
        check_task(task, self.scenario)
        n, control = len(self.scenario.stages), self.scenario.control
        self.task = spread_task(task, n)
        self.law: ActionLaw = make_action_law(task, self.scenario)
        names = control.impedance.coordinates
        self.selected = parse_coordinates(names, n) != 0.0
        self._numbers = pack_brace(self.scenario)
        ticks = round(task.sample_time * control.rate) * task.max_steps
        rows = ticks + 1 if task.readings == "noisy" else 0
        self._draws = rows, 9 * n + 3

    def stiffness(self, action: np.ndarray) -> np.ndarray:
        """Of all coordinates (6n,), N/m, 0 where there is no impedance; of
        actions (N, k) those of each (N, 6n).
        """
        asked = np.zeros((*action.shape[:-1], len(self.selected)))
        asked[..., self.selected] = self.law.stiffness(action)
        return asked

    def draw(
        self, generator: np.random.Generator, subject: Subject | None = None
    ) -> Episode:
        """Draws an episode; a subject that is given replaces the drawn one."""
        task = self.task
        drawn = draw_subject(task.subjects, generator)
        subject = drawn if subject is None else subject
        factors = {**NOMINAL.factors, **subject.factors}
        return Episode(
            subject=subject,
            numbers=_scale_numbers(self._numbers, factors),
            uses=tuple(uses_of(task.subjects, subject)),
            way=task.displacement * factors["displacement"],
            draws=generator.standard_normal(self._draws),
        )


def _scale_numbers(
    numbers: BraceNumbers, factors: dict[str, float]
) -> BraceNumbers:
    contact, posture = numbers.contact.copy(), numbers.posture.copy()
    contact[:, 0] *= factors["contact_stiffness"]
    contact[:, 1] *= factors["contact_damping"]
    contact[:, 5] *= factors["preload"]
    for first in (0, 6):
        posture[first : first + 3] *= factors["posture_stiffness"]
        posture[first + 3 : first + 6] *= factors["posture_damping"]
    return numbers.with_changes(
        contact=contact,
        posture=posture,
        torso=numbers.torso * factors["torso_mass"],
    )


@dataclass(frozen=True)
class EpisodeLog:
    """What happened at each decision; rows are instants after a step.

    Attributes:
        signals: The truth (steps, 6n).
        stiffness: In use (steps, k), N/m.
        rewards: (steps,).
        cause: Why it ended early; "" where it did not.
    """

    signals: Signals
    stiffness: np.ndarray
    rewards: np.ndarray
    cause: str

    @property
    def total(self) -> float:
        """The return."""
        return float(self.rewards.sum())


def run_episode(
    env: gymnasium.Env,
    act: Callable[[np.ndarray], np.ndarray],
    seed: int = 0,
    options: dict | None = None,
) -> EpisodeLog:
    """Runs one episode, of the nominal subject unless options say otherwise.

    Args:
        env: RlpicEnv, of the policy's task.
        act: From observation to action, as `Policy.act` is.
        seed: Of the env.
        options: Of `RlpicEnv.reset`.
    """
    options = {"nominal": True} if options is None else options
    observation, _ = env.reset(seed=seed, options=options)
    signals, stiffness, rewards, over, cause = [], [], [], False, ""
    while not over:
        observation, reward, ended, cut, info = env.step(act(observation))
        rewards.append(reward)
        cause = info.get("failure", info.get("cause", ""))
        over = ended or cut
        if "failure" not in info:
            signals.append(env.loop.truth())
            stiffness.append(info["stiffness"])
    return EpisodeLog(
        stack_signals(signals, len(env.prepared.selected)),
        np.array(stiffness),
        np.array(rewards),
        cause,
    )

"""RLPIC as a gymnasium env, on the diagram or on its compiled laws."""

from __future__ import annotations

from typing import ClassVar

import gymnasium
import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.learning.compiled_loop import CompiledLoop
from brace_drake.learning.diagram_loop import DiagramLoop
from brace_drake.learning.episode import Episode, PreparedTask
from brace_drake.learning.rewards import calc_reward, find_violation
from brace_drake.learning.signals import (
    OBSERVERS,
    observation_size,
    signals_of_estimate,
)
from brace_drake.learning.subjects import NOMINAL, Subject
from brace_drake.learning.task import LearningTask, full_task

LOOPS = {"compiled": CompiledLoop, "diagram": DiagramLoop}
NOT_FINITE_ACTION = "the action is not finite"
NOT_FINITE = "an observation or the reward is not finite"
# What a simulation that fails raises; DRAKE_DEMAND ends in SystemExit. Other
# exceptions are mistakes in a program and go to the caller.
FAILURES = (RuntimeError, ArithmeticError, ValueError, BraceError, SystemExit)


class RlpicEnv(gymnasium.Env):
    """A policy sets the stiffness of the brace's impedance, section 3.

    Observation: see `signals`, of what the controller has measured. Action:
    -1 to 1 for each coordinate with an impedance, cut to the scenario's range
    of stiffness and to the task's rate. Reward and limits look at the truth,
    which a twin knows: a sensor that errs must not pay.

    A decision at time t sees the control tick at t and acts from the next.

    `info` has `reward_terms`; `stiffness` in use, N/m; `subject`; `clipped`,
    the actions so far that had to be cut to their space; at the end `episode`
    with return r, length l and the causes that ended it: `cause`, a limit that
    was passed, or `failure`: the simulation broke down, or a number is not
    finite.

    `reset(options={"subject": Subject})` takes a subject in place of a drawn
    one; `{"nominal": True}` the scenario's own.

    Args:
        task: See `LearningTask`; None is the paper's.
        render_mode: human or ansi, on the diagram.

    Raises:
        ScenarioError: Task or scenario are not allowed: key, value, range.
    """

    metadata: ClassVar[dict] = {
        "render_modes": ["human", "ansi"],
        "render_fps": 20,
    }

    def __init__(
        self,
        task: LearningTask | None = None,
        render_mode: str | None = None,
    ):
        self.prepared = PreparedTask(LearningTask() if task is None else task)
        self.task = task = self.prepared.task
        self.scenario, self.law = self.prepared.scenario, self.prepared.law
        self.time_step, self.render_mode = task.sample_time, render_mode
        self.loop = LOOPS[task.backend](
            self.scenario, task.sample_time, task.motion_time
        )
        size = observation_size(task.observation, len(self.prepared.selected))
        self.observation_space = gymnasium.spaces.Box(
            -np.inf, np.inf, (size,), np.float64
        )
        self.action_space = gymnasium.spaces.Box(
            -1.0, 1.0, self.law.start.shape, np.float64
        )
        self._episode: Episode | None = None
        self._ended = True

    def reset(self, *, seed: int | None = None, options: dict | None = None):
        """Starts an episode; see `gymnasium.Env.reset`.

        Raises:
            ValueError: There is no such option.
            BraceError, RuntimeError: The start itself fails.
        """
        super().reset(seed=seed)
        self._ended, options = True, options or {}
        self._before = self.np_random.bit_generator.state
        self._options, self._actions = options, []
        self._episode = episode = self.prepared.draw(
            self.np_random, _subject_of(options)
        )
        self._held = self.law.action(self.law.start)
        self._return, self._clipped, self._num_steps = 0.0, 0, 0
        self.loop.start(episode, self.prepared.stiffness(self._held))
        self._observation = self._Observe()
        self._ended = False
        info = {"subject": episode.subject.describe()}
        return self._observation.copy(), info

    def step(self, action: np.ndarray):
        """Takes one step; see `gymnasium.Env.step`.

        Raises:
            gymnasium.error.ResetNeeded: The episode has ended.
        """
        if self._ended:
            raise gymnasium.error.ResetNeeded(
                "the episode has ended: call reset() before step()"
            )
        action = np.asarray(action, dtype=np.float64)
        if action.shape != self.action_space.shape:
            raise ValueError(
                f"action has shape {action.shape}; allowed:"
                f" {self.action_space.shape}"
            )
        self._num_steps += 1
        if not np.isfinite(action).all():
            return self._Fail(NOT_FINITE_ACTION)
        self._clipped += int((np.abs(action) > 1.0).any())
        self._actions.append(action)
        before, self._held = self._held, self.law.limit(action, self._held)
        self._ended = True
        try:
            self.loop.advance(self.prepared.stiffness(self._held))
            observation = self._Observe()
        except FAILURES as error:
            line = " ".join(str(error).split())
            return self._Fail(f"{type(error).__name__}: {line}")
        signals = self.loop.truth()
        found = calc_reward(
            signals, 0.5 * (self._held - before), self.task.reward
        )
        terms = {name: float(term) for name, term in found.items()}
        reward = sum(terms.values())
        if not np.isfinite(observation).all() or not np.isfinite(reward):
            return self._Fail(NOT_FINITE)
        self._observation = observation
        info = {
            "reward_terms": terms,
            "stiffness": self.loop.stiffness[self.prepared.selected].copy(),
            "clipped": self._clipped,
        }
        cause = find_violation(signals, self.task.limits, self.scenario.rings)
        if cause:
            info["cause"] = cause
        terminated = bool(cause)
        truncated = not terminated and self._num_steps >= self.task.max_steps
        self._return += reward
        self._ended = terminated or truncated
        if self._ended:
            info["episode"] = {"r": self._return, "l": self._num_steps}
            info["subject"] = self._episode.subject.describe()
        return observation.copy(), reward, terminated, truncated, info

    def render(self):
        """Publishes the diagram (human), or returns its context (ansi)."""
        if self._episode is None or not isinstance(self.loop, DiagramLoop):
            raise gymnasium.error.ResetNeeded(
                "drawn is the diagram (backend: diagram) after reset()"
            )
        context = self.loop.simulator.get_context()
        if self.render_mode == "ansi":
            return str(context)
        if self.render_mode == "human":
            self.loop.diagram.ForcedPublish(context)
        return None

    def Snapshot(self) -> dict:
        """What brings the env to where it is: its draws and its actions."""
        return {
            "generator": self._before,
            "options": self._options,
            "actions": np.array(self._actions),
        }

    def Restore(self, snapshot: dict) -> np.ndarray:
        """Replays a snapshot, bit for bit; returns the last observation."""
        self.np_random.bit_generator.state = snapshot["generator"]
        observation, _ = self.reset(options=snapshot["options"])
        for action in snapshot["actions"]:
            observation = self.step(action)[0]
        return observation

    def _Observe(self) -> np.ndarray:
        loop, observe = self.loop, OBSERVERS[self.task.observation]
        return observe(signals_of_estimate(loop.estimate, loop.desired))

    def _Fail(self, cause: str):
        """What a step that failed comes back with."""
        self._ended, reward = True, self.task.failure_reward
        info = {
            "failure": cause,
            "clipped": self._clipped,
            "episode": {"r": self._return + reward, "l": self._num_steps},
        }
        return self._observation.copy(), reward, True, False, info


def make_full_env(
    task: LearningTask | None = None, render_mode: str | None = None
) -> RlpicEnv:
    """`BraceDrake/RLPIC-Full-v0`."""
    return RlpicEnv(full_task() if task is None else task, render_mode)


def _subject_of(options: dict) -> Subject | None:
    """The subject that a reset asks for."""
    unknown = set(options) - {"subject", "nominal"}
    if unknown:
        raise ValueError(
            f"reset: options {sorted(unknown)}; allowed: subject, nominal"
        )
    return NOMINAL if options.get("nominal") else options.get("subject")

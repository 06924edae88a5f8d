"""RLPIC as a gymnasium env, on the diagram or on its compiled laws."""

from __future__ import annotations

import gymnasium
import numpy as np
from pydrake.systems.analysis import Simulator

from brace_drake.learning.compiled_loop import CompiledLoop
from brace_drake.learning.diagram_loop import DiagramLoop
from brace_drake.learning.drake_env import RepairedDrakeGymEnv
from brace_drake.learning.episode import Episode, draw_episode
from brace_drake.learning.limits import find_violation
from brace_drake.learning.rewards import calc_reward
from brace_drake.learning.signals import (
    OBSERVERS,
    observation_size,
    signals_of_estimate,
)
from brace_drake.learning.subjects import NOMINAL, Subject
from brace_drake.learning.task import (
    LearningTask,
    check_task,
    load_task_scenario,
    make_action_law,
    spread_task,
)
from brace_drake.model.systems.ticks import TICK_LEAD
from brace_drake.scenario.brace_numbers import pack_brace
from brace_drake.scenario.control_numbers import parse_coordinates


class RlpicEnv(RepairedDrakeGymEnv):
    """A policy sets the stiffness of the brace's impedance, section 3.

    Observation: see `signals`, of what the controller has measured. Action:
    -1 to 1 for each coordinate with an impedance, cut to the scenario's range
    of stiffness and to the task's rate. Reward and limits look at the truth,
    which a twin knows: a sensor that errs must not pay.

    A decision at time t sees the control tick at t and acts from the next.

    `info` has `reward_terms`; `stiffness` in use, N/m; `subject`; `clipped`;
    at the end `episode` with return r, length l and the causes that ended it:
    `cause`, a limit that was passed, or `failure`, of the simulation.

    `reset(options={"subject": Subject})` takes a subject in place of a drawn
    one; `{"nominal": True}` the scenario's own.

    Args:
        task: See `LearningTask`; None is the paper's.
        render_mode: human or ansi, on the diagram.

    Raises:
        ScenarioError: Task or scenario are not allowed: key, value, range.
    """

    def __init__(
        self,
        task: LearningTask | None = None,
        render_mode: str | None = None,
    ):
        task = LearningTask() if task is None else task
        self.scenario = scenario = load_task_scenario(task)
        check_task(task, scenario)
        n = len(scenario.stages)
        self.task = task = spread_task(task, n)
        self._numbers = pack_brace(scenario)
        torso = scenario.torso
        self._torso = np.array([torso.mass, *torso.inertia])
        self.law = make_action_law(task, scenario)
        names = scenario.control.impedance.coordinates
        self.selected = parse_coordinates(names, n) != 0.0
        self._observe = OBSERVERS[task.observation]
        ticks = round(task.sample_time * scenario.control.rate)
        self._ticks = ticks * task.max_steps
        self._episode: Episode | None = None
        self._loop: DiagramLoop | None = None
        self._compiled = None
        if task.backend == "compiled":
            self._compiled = CompiledLoop(
                scenario, task.sample_time, task.motion_time
            )
        size = observation_size(task.observation, 6 * n)
        super().__init__(
            self._MakeSimulator,
            task.sample_time,
            gymnasium.spaces.Box(-1.0, 1.0, self.law.start.shape, np.float64),
            gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float64),
            lambda system, context: 0.0,
            action_port_id="action",
            observation_port_id="observation",
            neutral_action=self.law.action(self.law.start),
            failure_reward=task.failure_reward,
            render_mode=render_mode,
        )

    def _MakeSimulator(self, generator) -> Simulator:
        """The simulator of the episode; rebuilt where effects change."""
        episode, loop = self._episode, self._loop
        if loop is None or episode.uses:
            task = self.task
            self._loop = loop = DiagramLoop(
                self.scenario,
                self.law,
                self.selected,
                task.observation,
                (task.sample_time, task.motion_time),
                episode,
            )
        return loop.simulator

    @property
    def loop(self) -> CompiledLoop | DiagramLoop:
        """What is simulated."""
        return self._loop if self._compiled is None else self._compiled

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

    def _Restart(self, seed: int | None, options: dict) -> dict:
        self._before = self.np_random.bit_generator.state
        self._options, self._actions = options, []
        self._episode = episode = draw_episode(
            self.task,
            self._numbers,
            self._torso,
            self._ticks,
            self.np_random,
            _subject_of(options),
        )
        self._held = self.law.action(self.law.start)
        self._return = 0.0
        if self._compiled is not None:
            self._compiled.start(episode, self._Stiffness())
        else:
            self.simulator = self._MakeSimulator(self.generator)
            self._setup()
            self._loop.SetEpisode(episode)
            context = self.simulator.get_mutable_context()
            self.action_port.FixValue(context, self._neutral)
            self.simulator.Initialize()
        return {"subject": episode.subject.describe()}

    def _Stiffness(self) -> np.ndarray:
        asked = np.zeros(len(self.selected))
        asked[self.selected] = self.law.stiffness(self._held)
        return asked

    def _Advance(self, action: np.ndarray) -> bool:
        self._actions.append(action)
        before, self._held = self._held, self.law.limit(action, self._held)
        self._change = 0.5 * (self._held - before)
        if self._compiled is None:
            return super()._Advance(action)
        self._compiled.advance(self._Stiffness())
        return False

    def _Boundary(self, step: int) -> float:
        # After the tick of that time, before the plant moves on.
        return super()._Boundary(step) - 0.5 * TICK_LEAD

    def _Observe(self) -> np.ndarray:
        if self._compiled is None:
            return super()._Observe()
        loop = self._compiled
        return self._observe(signals_of_estimate(loop.estimate, loop.desired))

    def _Judge(self) -> tuple[float, bool, bool, dict]:
        signals = self.loop.truth()
        terms = calc_reward(signals, self._change, self.task.reward)
        rings = self.scenario.rings
        cause = find_violation(signals, self.task.limits, rings)
        reward, terminated = sum(terms.values()), bool(cause)
        truncated = not terminated and self._num_steps >= self.task.max_steps
        self._return += reward
        info = {
            "reward_terms": terms,
            "stiffness": self.loop.stiffness[self.selected].copy(),
        }
        if cause:
            info["cause"] = cause
        if terminated or truncated:
            info["episode"] = {"r": self._return, "l": self._num_steps}
            info["subject"] = self._episode.subject.describe()
        return reward, terminated, truncated, info

    def _Fail(self, cause: str):
        result = super()._Fail(cause)
        total = self._return + self.failure_reward
        result[-1]["episode"] = {"r": total, "l": self._num_steps + 1}
        return result


def _subject_of(options: dict) -> Subject | None:
    """The subject that a reset asks for."""
    unknown = set(options) - {"subject", "nominal"}
    if unknown:
        raise ValueError(
            f"reset: options {sorted(unknown)}; allowed: subject, nominal"
        )
    return NOMINAL if options.get("nominal") else options.get("subject")

"""Drake's own gymnasium env, with its defects repaired."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import gymnasium
import numpy as np
from pydrake.common import RandomGenerator
from pydrake.gym import DrakeGymEnv
from pydrake.systems.analysis import Simulator, SimulatorStatus

from brace_drake.core.errors import BraceError

# What a simulation that fails raises; DRAKE_DEMAND ends in SystemExit. Other
# exceptions are mistakes in a program and go to the caller.
FAILURES = (RuntimeError, ArithmeticError, ValueError, BraceError, SystemExit)
_SEEDS = 2**63
_BEFORE = 1e-12


class RepairedDrakeGymEnv(DrakeGymEnv):
    """`DrakeGymEnv` (1.51) as a learning agent can rely on it.

    What differs: `info_handler` is called. Steps are counted, so that all
    have the same events. A failure or a number that is not finite
    ends the episode (`terminated`) with its cause in `info["failure"]`, and no
    step is taken after an end. A reset puts state and action back before
    initialization. `metadata` is the env's own. Actions are cut to their space
    and the cuts counted in `info["clipped"]`. Options and spaces of the wrong
    kind are refused in words.

    Args:
        simulator: A Simulator, or a function RandomGenerator -> Simulator.
        time_step: Of the env, s.
        action_space, observation_space: Boxes of float64.
        reward: Function (system, context) -> float, or an output port's name.
        action_port_id, observation_port_id: Names of ports of the system.
        reset_handler: Function (simulator, context, seed), after the default
            context is set and before initialization; without it the context is
            drawn at random.
        info_handler: Function (simulator) -> dict.
        neutral_action: On the port until the first step; default 0.
        failure_reward: Of a step that fails.
        render_mode: human, ansi or None.

    Raises:
        ValueError: A space is not a Box of float64.
    """

    metadata: ClassVar[dict] = {
        "render_modes": ["human", "ansi"],
        "render_fps": 20,
    }

    def __init__(
        self,
        simulator: Simulator | Callable[[RandomGenerator], Simulator],
        time_step: float,
        action_space: gymnasium.spaces.Box,
        observation_space: gymnasium.spaces.Box,
        reward: Callable | str,
        *,
        action_port_id: str,
        observation_port_id: str,
        reset_handler: Callable | None = None,
        info_handler: Callable | None = None,
        neutral_action: np.ndarray | None = None,
        failure_reward: float = 0.0,
        render_mode: str | None = None,
    ):
        for name, space in (
            ("action_space", action_space),
            ("observation_space", observation_space),
        ):
            box = isinstance(space, gymnasium.spaces.Box)
            if not box or space.dtype != np.float64:
                raise ValueError(f"{name}: {space!r}; allowed: Box of float64")
        # The base class writes into whatever `self.metadata` is.
        self.metadata = dict(type(self).metadata)
        super().__init__(
            simulator,
            time_step,
            action_space,
            observation_space,
            reward,
            action_port_id=action_port_id,
            observation_port_id=observation_port_id,
            render_mode=render_mode,
            reset_handler=reset_handler,
        )
        self.metadata = dict(type(self).metadata)
        if info_handler is not None:
            self.info_handler = info_handler
        self.failure_reward = float(failure_reward)
        shape = action_space.shape
        self._neutral = (
            np.zeros(shape) if neutral_action is None else neutral_action
        )
        self._ended = True
        self._num_steps = self._clipped = 0
        self._observation = np.zeros(observation_space.shape)

    def reset(self, *, seed: int | None = None, options: dict | None = None):
        """Starts an episode; see `gymnasium.Env.reset`.

        Raises:
            ValueError: There are options, and this env has none.
            BraceError, RuntimeError: The start itself fails.
        """
        gymnasium.Env.reset(self, seed=seed)
        if seed is not None:
            self.generator = RandomGenerator(seed % _SEEDS)
        self._ended, self._num_steps, self._clipped = True, 0, 0
        info = self._Restart(seed, options or {})
        self._observation = self._Observe()
        self._ended = False
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
        if not np.isfinite(action).all():
            return self._Fail("the action is not finite")
        space = self.action_space
        cut = np.clip(action, space.low, space.high)
        self._clipped += int((cut != action).any())
        self._ended = True
        try:
            terminated = self._Advance(cut)
            observation = self._Observe()
        except FAILURES as error:
            line = " ".join(str(error).split())
            return self._Fail(f"{type(error).__name__}: {line}")
        self._num_steps += 1
        reward, more, truncated, info = self._Judge()
        if not np.isfinite(observation).all():
            return self._Fail("an observation is not finite")
        if not np.isfinite(reward):
            return self._Fail("the reward is not finite")
        terminated = terminated or more
        info["clipped"] = self._clipped
        self._observation = observation
        self._ended = terminated or truncated
        return observation.copy(), reward, terminated, truncated, info

    def render(self):
        """Draws (human: publishes), or returns the context's text (ansi)."""
        if self.simulator is None:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        context = self.simulator.get_context()
        if self.render_mode == "ansi":
            return str(context)
        if self.render_mode == "human":
            self.simulator.get_system().ForcedPublish(context)
        return None

    def _Fail(self, cause: str):
        """What a step that failed comes back with."""
        self._ended = True
        info = {"failure": cause, "clipped": self._clipped}
        return self._observation.copy(), self.failure_reward, True, False, info

    def _Restart(self, seed: int | None, options: dict) -> dict:
        """Sets the simulator to a new episode's start; returns its info."""
        if options:
            raise ValueError(f"reset has no options; got {sorted(options)}")
        if self.make_simulator:
            self.simulator = self.make_simulator(self.generator)
            self._setup()
        context = self.simulator.get_mutable_context()
        system = self.simulator.get_system()
        context.SetTime(0.0)
        system.SetDefaultContext(context)
        if self.reset_handler is not None:
            self.reset_handler(self.simulator, context, seed)
        elif not self.hardware:
            system.SetRandomContext(context, self.generator)
        self.action_port.FixValue(context, self._neutral)
        self.simulator.Initialize()
        return self.info_handler(self.simulator)

    def _Advance(self, action: np.ndarray) -> bool:
        """Simulates one step; whether a monitor has ended it."""
        self.action_port.FixValue(self.simulator.get_mutable_context(), action)
        status = self.simulator.AdvanceTo(self._Boundary(self._num_steps + 1))
        reached = SimulatorStatus.ReturnReason.kReachedTerminationCondition
        return status.reason() == reached

    def _Boundary(self, step: int) -> float:
        """Time of a step's end, s.

        A sum of steps would drift across events. Events at an end belong to
        the next step; rounding must not decide.
        """
        return step * self.time_step * (1.0 - _BEFORE)

    def _Observe(self) -> np.ndarray:
        context = self.simulator.get_context()
        return np.array(self.observation_port.Eval(context), dtype=np.float64)

    def _Judge(self) -> tuple[float, bool, bool, dict]:
        """Reward, whether the step ends or cuts the episode, and info."""
        simulator = self.simulator
        context = simulator.get_context()
        reward = float(self.reward(simulator.get_system(), context))
        return reward, False, False, dict(self.info_handler(simulator))

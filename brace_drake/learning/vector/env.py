"""RLPIC as a gymnasium vector env: many episodes in one pass."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

from brace_drake.learning.env import NOT_FINITE, NOT_FINITE_ACTION, RlpicEnv
from brace_drake.learning.rewards import (
    calc_reward,
    find_violation,
    passes_limit,
)
from brace_drake.learning.signals import OBSERVERS, Signals
from brace_drake.learning.task import LearningTask, full_task
from brace_drake.learning.vector.copies import CompiledCopies
from brace_drake.learning.vector.steps import Steps


class RlpicVectorEnv(VectorEnv):
    """`RlpicEnv` n times, four episodes in each pass of compiled code.

    Seeds, options, observations, rewards, ends and `infos` are those of
    gymnasium's `SyncVectorEnv` of n single envs, to the last bit:
    `reset(seed=s)` seeds episode i with s + i, a list gives each its own, and
    `options={"reset_mask": mask}` resets some. `metadata["autoreset_mode"]`
    says when an episode that has ended begins anew.

    Args:
        num_envs: n.
        task: Of all episodes, compiled; None is the paper's.
        autoreset_mode: See `gymnasium.vector.AutoresetMode`.

    Raises:
        ScenarioError: Task or scenario are not allowed: key, value, range.
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: LearningTask | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    ):
        # The single env draws, starts and describes; copies of it go on.
        self._one = one = RlpicEnv(task)
        self.num_envs, self.task, self.prepared = (
            num_envs,
            one.task,
            one.prepared,
        )
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        own = {"autoreset_mode": self.autoreset_mode, "render_modes": []}
        self.metadata = {**one.metadata, **own}
        self.single_observation_space = one.observation_space
        self.single_action_space = one.action_space
        self.observation_space = batch_space(one.observation_space, num_envs)
        self.action_space = batch_space(one.action_space, num_envs)
        self._loops = CompiledCopies(
            one.scenario, one.task.sample_time, one.task.motion_time, num_envs
        )
        self._generators: list[np.random.Generator] = [
            seeding.np_random()[0] for _ in range(num_envs)
        ]
        self._records: list[dict[str, Any]] = [{} for _ in range(num_envs)]
        self._held = np.zeros((num_envs, *one.action_space.shape))
        self._observations = np.zeros(self.observation_space.shape)
        self._returns = np.zeros(num_envs)
        self._lengths = np.zeros(num_envs, dtype=int)
        self._clipped = np.zeros(num_envs, dtype=int)
        self._ended = np.ones(num_envs, dtype=bool)

    @property
    def np_random(self) -> tuple[np.random.Generator, ...]:
        """Of each episode."""
        return tuple(self._generators)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict | None = None,
    ):
        """Starts episodes; see `gymnasium.vector.SyncVectorEnv.reset`.

        Raises:
            ValueError: There is no such option, or a seed too few.
            BraceError: A start itself fails.
        """
        n, options = self.num_envs, dict(options or {})
        mask = _check_mask(options.pop("reset_mask", np.ones(n, bool)), n)
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else seed + i for i in range(n)]
        else:
            seeds = list(seed)
        if len(seeds) != n:
            raise ValueError(f"reset: {len(seeds)} seeds; allowed: {n}")
        infos = {}
        for i in np.flatnonzero(mask):
            if seeds[i] is not None:
                self._generators[i] = seeding.np_random(seeds[i])[0]
            infos = self._add_info(infos, self._Start(i, options), i)
        return self._observations.copy(), infos

    def step(self, actions: np.ndarray):
        """Takes a step of each; see `gymnasium.vector.SyncVectorEnv.step`.

        Raises:
            gymnasium.error.ResetNeeded: An episode has ended, and none begins
                by itself.
        """
        actions = np.asarray(actions, dtype=np.float64)
        if actions.shape != self.action_space.shape:
            raise ValueError(
                f"actions have shape {actions.shape}; allowed:"
                f" {self.action_space.shape}"
            )
        fresh = np.flatnonzero(self._ended)
        never = [i for i in fresh if not self._records[i]]
        if len(fresh) and (
            never or self.autoreset_mode != AutoresetMode.NEXT_STEP
        ):
            raise gymnasium.error.ResetNeeded(
                f"episode {(never or fresh)[0]} has ended: call reset() before"
                " step()"
            )
        own = self._Step(actions, ~self._ended)
        for i in fresh:
            own.infos[i] = self._Start(i, {})
        ended = own.terminated | own.truncated
        same_step = self.autoreset_mode == AutoresetMode.SAME_STEP
        infos = own.AsInfos()
        for i, info in own.infos.items():
            if ended[i] and same_step:
                final = {"final_obs": self._observations[i].copy()}
                final["final_info"] = info
                infos = self._add_info(infos, final, i)
                info = self._Start(i, {})
            infos = self._add_info(infos, info, i)
        seen = self._observations.copy()
        return seen, own.rewards, own.terminated, own.truncated, infos

    def Snapshot(self) -> list[dict]:
        """What brings each episode to where it is: its draws and actions."""
        return [
            {
                "generator": record["generator"],
                "options": record["options"],
                "actions": np.array(record["actions"]),
            }
            for record in self._records
        ]

    def Restore(self, snapshots: Sequence[dict]) -> np.ndarray:
        """Replays snapshots, bit for bit; returns the last observations."""
        for i, snapshot in enumerate(snapshots):
            self._generators[i].bit_generator.state = snapshot["generator"]
            self._Start(i, snapshot["options"])
        actions = [snapshot["actions"] for snapshot in snapshots]
        for k in range(max(len(own) for own in actions)):
            going = np.array([k < len(own) for own in actions])
            now = np.zeros(self.action_space.shape)
            for i in np.flatnonzero(going):
                now[i] = actions[i][k]
            self._Step(now, going)
        return self._observations.copy()

    def _Start(self, i: int, options: dict) -> dict:
        """Starts an episode; its info."""
        one, generator = self._one, self._generators[i]
        self._records[i] = {
            "generator": generator.bit_generator.state,
            "options": options,
            "actions": [],
        }
        self._ended[i] = True
        one.np_random = generator
        self._observations[i], info = one.reset(options=options)
        self._loops.put(i, one.loop)
        self._records[i]["subject"] = info["subject"]
        self._held[i] = one.law.action(one.law.start)
        self._returns[i] = self._lengths[i] = self._clipped[i] = 0
        self._ended[i] = False
        return info

    def _Step(self, actions: np.ndarray, going: np.ndarray) -> Steps:
        """A step of those that are going, as `RlpicEnv.step`."""
        task, law = self.task, self.prepared.law
        own = Steps(self.num_envs)
        self._lengths[going] += 1
        finite = np.isfinite(actions).all(axis=-1)
        for i in np.flatnonzero(going & ~finite):
            self._Fail(own, i, NOT_FINITE_ACTION)
        active = going & finite
        self._clipped[active] += (np.abs(actions[active]) > 1.0).any(axis=-1)
        before = self._held.copy()
        self._held[active] = law.limit(actions[active], before[active])
        places = np.flatnonzero(active)
        for i in places:
            self._records[i]["actions"].append(actions[i].copy())
        broken = self._loops.advance(
            self.prepared.stiffness(self._held), places.tolist()
        )
        for i, how in broken.items():
            active[i] = False
            self._Fail(own, i, f"BraceError: {how}")
        if not active.any():
            return own
        signals = self._loops.truth()
        change = 0.5 * (self._held - before)
        own.terms = calc_reward(signals, change, task.reward)
        rewards = sum(own.terms.values())
        observations = OBSERVERS[task.observation](self._loops.known())
        good = np.isfinite(rewards) & np.isfinite(observations).all(axis=-1)
        for i in np.flatnonzero(active & ~good):
            self._Fail(own, i, NOT_FINITE)
        active &= good
        self._observations[active] = observations[active]
        own.rewards[active] = rewards[active]
        self._returns[active] += rewards[active]
        own.stiffness = self._loops.stiffness()[:, self.prepared.selected]
        own.clipped, own.plain = self._clipped, active
        self._End(own, signals, active)
        return own

    def _End(self, own: Steps, signals: Signals, active: np.ndarray) -> None:
        """Ends the episodes whose end has come."""
        passed = active & passes_limit(signals, self.task.limits)
        own.terminated |= passed
        own.truncated |= (
            active & ~passed & (self._lengths >= self.task.max_steps)
        )
        ended = passed | own.truncated
        for i in np.flatnonzero(ended):
            info = own.InfoOf(i)
            if passed[i]:
                info["cause"] = find_violation(
                    Signals(*(part[i] for part in signals)),
                    self.task.limits,
                    self._one.scenario.rings,
                )
            info["episode"] = self._EpisodeOf(i)
            info["subject"] = self._records[i]["subject"]
            own.infos[i] = info
        own.plain = active & ~ended
        self._ended |= ended

    def _Fail(self, own: Steps, i: int, cause: str) -> None:
        """Ends an episode whose step has failed."""
        own.rewards[i] = self.task.failure_reward
        self._returns[i] += self.task.failure_reward
        own.terminated[i] = self._ended[i] = True
        own.infos[i] = {
            "failure": cause,
            "clipped": int(self._clipped[i]),
            "episode": self._EpisodeOf(i),
        }

    def _EpisodeOf(self, i: int) -> dict:
        return {"r": float(self._returns[i]), "l": int(self._lengths[i])}


def _check_mask(mask, n: int) -> np.ndarray:
    """Which episodes a reset is asked for."""
    good = isinstance(mask, np.ndarray) and mask.dtype == bool
    if not (good and mask.shape == (n,) and mask.any()):
        raise ValueError(
            f"reset: reset_mask {mask!r}; allowed: an array of {n} bools, one"
            " of them true"
        )
    return mask


def _make_vector_env(
    make_task: Callable[[], LearningTask],
    num_envs: int = 1,
    task: LearningTask | None = None,
    **options,
) -> VectorEnv:
    task = make_task() if task is None else task
    if task.backend == "compiled":
        return RlpicVectorEnv(num_envs, task, **options)
    return SyncVectorEnv([partial(RlpicEnv, task)] * num_envs, **options)


def make_vector_env(num_envs: int = 1, **options) -> VectorEnv:
    """`BraceDrake/RLPIC-v0` several times; on the diagram one by one."""
    return _make_vector_env(LearningTask, num_envs, **options)


def make_full_vector_env(num_envs: int = 1, **options) -> VectorEnv:
    """`BraceDrake/RLPIC-Full-v0` several times; on the diagram one by one."""
    return _make_vector_env(full_task, num_envs, **options)

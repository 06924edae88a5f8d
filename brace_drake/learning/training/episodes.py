"""The vector env as stable-baselines3 takes it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from brace_drake.learning.task import LearningTask
from brace_drake.learning.vector.env import RlpicVectorEnv


class EpisodesVecEnv(VecEnv):
    """Episodes side by side, each begun anew in the step that ends it.

    Args:
        task: Of all episodes, compiled.
        count: How many.
    """

    def __init__(self, task: LearningTask, count: int):
        self._envs = envs = RlpicVectorEnv(count, task, AutoresetMode.SAME_STEP)
        self._next: list[int | None] = [None] * count
        super().__init__(
            count, envs.single_observation_space, envs.single_action_space
        )

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Episode i gets seed + i with the next reset."""
        if seed is not None:
            self._next = [seed + i for i in range(self.num_envs)]
        return self._next

    def reset(self) -> np.ndarray:
        """Starts all episodes."""
        observations, _ = self._envs.reset(seed=self._next)
        self._next = [None] * self.num_envs
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Keeps the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self):
        """Observations, rewards, whether they ended, and their infos."""
        observations, rewards, ended, cut, infos = self._envs.step(
            self._actions
        )
        over = ended | cut
        found: list[dict] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(over):
            final = infos["final_info"]
            episode = {k: final["episode"][k][i].item() for k in ("r", "l")}
            found[i] = {
                "episode": episode,
                "terminal_observation": infos["final_obs"][i],
                "TimeLimit.truncated": bool(cut[i]),
            }
        return observations, rewards, over, found

    def Snapshot(self) -> list[dict]:
        """What brings each episode to where it is."""
        return self._envs.Snapshot()

    def Restore(self, snapshots: Sequence[dict]) -> None:
        """Replays snapshots, bit for bit."""
        self._envs.Restore(snapshots)

    def close(self) -> None:
        """There is nothing to close."""

    def get_attr(self, attr_name, indices=None) -> list:
        """The same of all episodes, as they have no envs of their own."""
        return [getattr(self._envs, attr_name)] * len(self._indices(indices))

    def set_attr(self, attr_name, value, indices=None) -> None:
        """There are no single envs whose attributes could be set.

        Raises:
            AttributeError: Always.
        """
        raise AttributeError(f"{attr_name}: episodes have no envs of their own")

    def env_method(self, method_name, *args, indices=None, **options) -> list:
        """There are no single envs whose methods could be called.

        Raises:
            AttributeError: Always.
        """
        raise AttributeError(
            f"{method_name}: episodes have no envs of their own"
        )

    def env_is_wrapped(self, wrapper_class, indices=None) -> list[bool]:
        """No episode is wrapped."""
        return [False] * len(self._indices(indices))

    def _indices(self, indices) -> list[int]:
        return list(self._get_indices(indices))

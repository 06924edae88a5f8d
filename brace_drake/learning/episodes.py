"""Whole episodes of a policy, or of a constant stiffness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.policy import Policy
from brace_drake.learning.signals import Signals


@dataclass(frozen=True)
class EpisodeLog:
    """What happened at each decision; rows are instants after a step.

    Attributes:
        signals: The truth (steps,).
        stiffness: In use (steps, k), N/m.
        rewards: (steps,).
        cause: Why it ended early; "" where it did not.
    """

    signals: tuple[Signals, ...]
    stiffness: np.ndarray
    rewards: np.ndarray
    cause: str

    @property
    def total(self) -> float:
        """The return."""
        return float(self.rewards.sum())

    def stack(self, name: str) -> np.ndarray:
        """One of the signals over the episode (steps, 6n)."""
        return np.array([getattr(s, name) for s in self.signals])


def run_episode(
    env: RlpicEnv,
    policy: Policy | Callable[[np.ndarray], np.ndarray],
    seed: int = 0,
    options: dict | None = None,
) -> EpisodeLog:
    """Runs one episode, of the nominal subject unless options say otherwise.

    Args:
        env: Of the policy's task.
        policy: Or any function from observation to action.
        seed: Of the env.
        options: Of `RlpicEnv.reset`.
    """
    act = policy.act if isinstance(policy, Policy) else policy
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
        tuple(signals), np.array(stiffness), np.array(rewards), cause
    )

"""PPO between two updates: everything it is, and how it goes on."""

from __future__ import annotations

import random
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from stable_baselines3.common.callbacks import ConvertCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import (
    DummyVecEnv,
    SubprocVecEnv,
    VecEnv,
    VecNormalize,
)

from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.episode import run_episode
from brace_drake.learning.policy import Policy
from brace_drake.learning.subjects import NOMINAL, Subject, draw_subject
from brace_drake.learning.task import LearningTask
from brace_drake.learning.training.actor_critic import ActorCritic
from brace_drake.learning.training.episodes import EpisodesVecEnv
from brace_drake.learning.training.numbers import TrainingNumbers
from brace_drake.learning.training.ppo import SplitPPO

# Of the draws of subjects that evaluations have.
_EVALUATED = 20_003
# Observations in SI are small: a micrometre counts.
_EPSILON = 1e-16
_CLIP = 10.0


class Learner:
    """PPO on a task, advanced update by update.

    Between updates its whole state can be taken and put back, so that it goes
    on bit for bit: weights, optimiser, scaling, all random states, and the
    episodes that are under way (replayed from their draws and actions).
    """

    def __init__(self, task: LearningTask, numbers: TrainingNumbers):
        # Sums over threads would not be the same every time.
        torch.set_num_threads(1)
        self.task, self.numbers = task, numbers
        self._envs = _make_envs(task, numbers.envs)
        self._scaled = VecNormalize(
            self._envs,
            norm_obs=numbers.scale_observations,
            norm_reward=numbers.scale_rewards,
            gamma=numbers.gamma,
            epsilon=_EPSILON,
            clip_obs=_CLIP if numbers.scale_observations else np.inf,
        )
        self.model = _make_ppo(self._scaled, numbers)
        self.model.set_logger(Logger(None, []))
        _, self._callback = self.model._setup_learn(
            0, ConvertCallback(lambda a, b: True), reset_num_timesteps=True
        )
        self.updates = 0
        self._reference = RlpicEnv(replace(task, readings="exact"))
        self._evaluated = _subjects_of(task, numbers.evaluated_subjects)

    def close(self) -> None:
        """Ends the envs' processes."""
        self._envs.close()

    @property
    def steps(self) -> int:
        """Decisions taken so far."""
        return self.model.num_timesteps

    def advance(self) -> dict[str, float]:
        """Collects a horizon and updates; numbers of it for the curve."""
        model = self.model
        model.collect_rollouts(
            model.env, self._callback, model.rollout_buffer, model.n_steps
        )
        model.train()
        self.updates += 1
        logged = self.model.logger.name_to_value
        row = {
            "updates": self.updates,
            "steps": self.steps,
            "episode_return": _mean(e["r"] for e in model.ep_info_buffer),
            "episode_length": _mean(e["l"] for e in model.ep_info_buffer),
            **{
                name: float(logged[f"train/{name}"])
                for name in ("value_loss", "approx_kl", "entropy_loss")
            },
        }
        logged.clear()
        return row

    def policy(self) -> Policy:
        """The actor as it is, for numpy."""
        weights, biases = self.model.policy.layers()
        env = self._reference
        size = len(env.observation_space.low)
        mean, gain, clip = np.zeros(size), np.ones(size), np.finfo(float).max
        if self.numbers.scale_observations:
            rms = self._scaled.obs_rms
            mean, gain = rms.mean.copy(), 1.0 / np.sqrt(rms.var + _EPSILON)
            clip = _CLIP
        return Policy(
            tuple(weights),
            tuple(biases),
            mean,
            gain,
            clip,
            env.law,
            env.prepared.selected,
            self.task,
        )

    def evaluate(self) -> float:
        """Mean return of the mean actions on subjects, noise off."""
        policy, env = self.policy(), self._reference
        return _mean(
            run_episode(env, policy.act, options={"subject": subject}).total
            for subject in self._evaluated
        )

    def state(self) -> dict:
        """Everything, for a file."""
        model, scaled = self.model, self._scaled
        return {
            "policy": model.policy.state_dict(),
            "optimizers": [o.state_dict() for o in model.policy.optimizers],
            "counts": {
                "num_timesteps": model.num_timesteps,
                "_n_updates": model._n_updates,
                "_episode_num": model._episode_num,
            },
            "updates": self.updates,
            "last_obs": np.array(model._last_obs),
            "last_starts": np.array(model._last_episode_starts),
            "episodes": list(model.ep_info_buffer),
            "scaling": {
                name: vars(getattr(scaled, name)).copy()
                for name in ("obs_rms", "ret_rms")
                if hasattr(scaled, name)
            },
            "returns": scaled.returns.copy(),
            "envs": _snapshots_of(self._envs),
            "random": (
                random.getstate(),
                np.random.get_state(),  # noqa: NPY002 (what PPO shuffles with)
                torch.get_rng_state(),
            ),
        }

    def set_state(self, state: dict) -> None:
        """Puts back what `state` has taken."""
        model, scaled = self.model, self._scaled
        model.policy.load_state_dict(state["policy"])
        for optimizer, own in zip(
            model.policy.optimizers, state["optimizers"], strict=True
        ):
            optimizer.load_state_dict(own)
        for name, value in state["counts"].items():
            setattr(model, name, value)
        self.updates = state["updates"]
        _restore(self._envs, state["envs"])
        model._last_obs = state["last_obs"].copy()
        model._last_episode_starts = state["last_starts"].copy()
        model.ep_info_buffer.clear()
        model.ep_info_buffer.extend(state["episodes"])
        for name, values in state["scaling"].items():
            vars(getattr(scaled, name)).update(values)
        scaled.returns = state["returns"].copy()
        random.setstate(state["random"][0])
        np.random.set_state(state["random"][1])  # noqa: NPY002
        torch.set_rng_state(state["random"][2])


def _make_envs(task: LearningTask, count: int) -> VecEnv:
    """Episodes side by side; on the diagram each in a process of its own."""
    if task.backend == "compiled":
        return EpisodesVecEnv(task, count)
    makers = [partial(RlpicEnv, task)] * count
    if count == 1:
        return DummyVecEnv(makers)
    return SubprocVecEnv(makers, start_method="forkserver")


def _snapshots_of(envs: VecEnv) -> list[dict]:
    if isinstance(envs, EpisodesVecEnv):
        return envs.Snapshot()
    return envs.env_method("Snapshot")


def _restore(envs: VecEnv, snapshots: list[dict]) -> None:
    if isinstance(envs, EpisodesVecEnv):
        envs.Restore(snapshots)
        return
    for i, snapshot in enumerate(snapshots):
        envs.env_method("Restore", snapshot, indices=i)


def _subjects_of(task: LearningTask, count: int) -> list[Subject]:
    """Subjects of an evaluation, none twice: the nominal one, and drawn ones.

    Where subjects have effects the nominal one, who has none, is left out.
    """
    drawn = [
        draw_subject(task.subjects, np.random.default_rng([_EVALUATED, i]))
        for i in range(count)
    ]
    if not task.subjects.effects:
        drawn = [NOMINAL, *drawn[: count - 1]]
    alike = {repr((s.factors, [*map(list, s.effects)])): s for s in drawn}
    return list(alike.values())


def _make_ppo(envs: VecNormalize, numbers: TrainingNumbers) -> SplitPPO:
    return SplitPPO(
        ActorCritic,
        envs,
        learning_rate=numbers.learning_rate,
        n_steps=numbers.horizon // numbers.envs,
        batch_size=min(numbers.batch_size, numbers.horizon),
        n_epochs=numbers.epochs,
        gamma=numbers.gamma,
        gae_lambda=numbers.gae_factor,
        clip_range=numbers.clip,
        ent_coef=numbers.entropy_weight,
        # The gradient of half the squared error, as the paper's tool has it.
        vf_coef=0.5,
        # Each parameter is cut by itself, see ThresholdAdam.
        max_grad_norm=float("inf"),
        policy_kwargs={
            "net_arch": {
                "pi": [numbers.hidden] * 2,
                "vf": [numbers.hidden] * 2,
            },
            "activation_fn": torch.nn.ReLU,
            "actor_l2": numbers.actor_l2,
            "critic_l2": numbers.critic_l2,
            "threshold": numbers.gradient_threshold,
            "start_deviation": numbers.start_deviation,
            "largest_deviation": numbers.largest_deviation,
        },
        seed=numbers.seed,
        device="cpu",
    )


def _mean(values) -> float:
    values = list(values)
    return float(np.mean(values)) if values else float("nan")

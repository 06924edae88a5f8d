"""PPO whose actor and critic are updated side by side."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import torch
from stable_baselines3 import PPO
from torch import nn

_HALF_LOG_TWO_PI = 0.5 * math.log(2.0 * math.pi)


class SplitPPO(PPO):
    """PPO of stable-baselines3 for an `ActorCritic`, updated faster.

    Actor and critic share no parameter, and the loss is a sum of one term of
    each: each is updated by itself, on the same minibatches in the same
    order, in a thread of its own. What comes out does not depend on which
    thread is faster.
    """

    def train(self) -> None:
        """Updates actor and critic on the horizon that was collected."""
        self.policy.set_training_mode(True)
        for optimizer in self.policy.optimizers:
            self._update_learning_rate(optimizer)
        buffer = self.rollout_buffer
        size = buffer.buffer_size * buffer.n_envs
        # One permutation in each epoch, as the buffer draws them.
        batches = [
            torch.from_numpy(order[at : at + self.batch_size])
            for order in (
                np.random.permutation(size)  # noqa: NPY002
                for _ in range(self.n_epochs)
            )
            for at in range(0, size, self.batch_size)
        ]
        seen, actions, advantages, returns, log_prob = (
            torch.from_numpy(buffer.swap_and_flatten(a).astype(np.float32))
            for a in (
                buffer.observations, buffer.actions, buffer.advantages,
                buffer.returns, buffer.log_probs,
            )
        )  # fmt: skip
        parts = (actions, advantages.flatten(), log_prob.flatten())
        with ThreadPoolExecutor(1, initializer=_one_thread) as other:
            critic = other.submit(
                self._TrainCritic, batches, seen, returns.flatten()
            )
            divergence, entropy = self._TrainActor(batches, seen, *parts)
            error = critic.result()
        self._n_updates += self.n_epochs
        in_epoch = len(batches) // self.n_epochs
        self.logger.record("train/value_loss", _mean(error))
        self.logger.record("train/entropy_loss", -_mean(entropy))
        self.logger.record("train/approx_kl", _mean(divergence[-in_epoch:]))

    def _TrainActor(self, batches, seen, actions, advantages, log_prob):
        """PPO's clipped gain and entropy; divergences and entropies of it."""
        policy, optimizer = self.policy, self.policy.optimizers[0]
        clip, divergences, entropies = self.clip_range(1.0), [], []
        for batch in batches:
            A, before = advantages[batch], log_prob[batch]
            if len(A) > 1:
                A = (A - A.mean()) / (A.std() + 1e-8)
            mean, deviation = policy.Actor(seen[batch])
            log_deviation = deviation.log()
            off = (actions[batch] - mean) / deviation
            now = (-0.5 * off * off - log_deviation - _HALF_LOG_TWO_PI).sum(1)
            entropy = (0.5 + _HALF_LOG_TWO_PI + log_deviation).sum(1).mean()
            change = now - before
            ratio = change.exp()
            gain = torch.min(A * ratio, A * ratio.clamp(1 - clip, 1 + clip))
            loss = -gain.mean() - self.ent_coef * entropy
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            divergences.append((ratio.detach() - 1 - change.detach()).mean())
            entropies.append(entropy.detach())
        return divergences, entropies

    def _TrainCritic(self, batches, seen, returns) -> list[torch.Tensor]:
        """Squared error of the returns; its course."""
        policy, optimizer = self.policy, self.policy.optimizers[1]
        errors = []
        for batch in batches:
            values = policy.Critic(seen[batch]).flatten()
            error = nn.functional.mse_loss(values, returns[batch])
            optimizer.zero_grad()
            (self.vf_coef * error).backward()
            optimizer.step()
            errors.append(error.detach())
        return errors


def _one_thread() -> None:
    # Sums over threads would not be the same every time.
    torch.set_num_threads(1)


def _mean(values: list[torch.Tensor]) -> float:
    return float(torch.stack(values).mean())

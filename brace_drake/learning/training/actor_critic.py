"""The paper's actor and critic as a policy of stable-baselines3."""

from __future__ import annotations

import math

import numpy as np
import torch
from stable_baselines3.common.distributions import Distribution
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import nn

_LEAST_DEVIATION = 1e-3


class ThresholdAdam(torch.optim.Adam):
    """Adam that first cuts the gradient of each parameter to an L2 norm.

    The paper's "gradient threshold method L2 norm": of each weight matrix and
    bias by itself, not of all together. Weight decay is added to the gradient
    after that, as L2 regularization.
    """

    def __init__(self, params, threshold: float = 1.0, **options):
        self._threshold = threshold
        super().__init__(params, fused=True, **options)

    @torch.no_grad()
    def step(self, closure=None):
        for group in self.param_groups:
            grads = [p.grad for p in group["params"] if p.grad is not None]
            # A factor of 1 leaves a gradient below the threshold as it is.
            norms = torch.stack(torch._foreach_norm(grads))
            factors = self._threshold / norms.clamp(min=self._threshold)
            torch._foreach_mul_(grads, list(factors.unbind()))
        return super().step(closure)


class ActorCritic(ActorCriticPolicy):
    """Section 3: two layers of 256 with ReLU, for actor and critic each.

    The actor has one more layer and tanh, the mean, in parallel with a layer
    for the deviation (softplus). Actor and critic share nothing and have an L2
    weight each.

    The deviation is cut at `largest_deviation`. An env cuts actions at +-1, so
    beyond that a wider one changes nothing but the entropy that is paid for:
    without a limit it grows over all bounds and the actions become noise.
    """

    def __init__(
        self,
        *args,
        actor_l2: float = 1e-5,
        critic_l2: float = 2e-4,
        threshold: float = 1.0,
        start_deviation: float = 0.5,
        largest_deviation: float = 1.0,
        **options,
    ):
        self._own = (actor_l2, critic_l2, threshold, start_deviation)
        self._largest = largest_deviation
        super().__init__(*args, **options)

    def _build(self, lr_schedule) -> None:
        actor_l2, critic_l2, threshold, deviation = self._own
        self._build_mlp_extractor()
        hidden, size = self.mlp_extractor.latent_dim_pi, self.action_space.shape
        self.action_net = nn.Linear(hidden, size[0])
        self.deviation_net = nn.Linear(hidden, size[0])
        self.value_net = nn.Linear(self.mlp_extractor.latent_dim_vf, 1)
        for module, gain in (
            (self.mlp_extractor, math.sqrt(2.0)),
            (self.action_net, 0.01),
            (self.deviation_net, 0.01),
            (self.value_net, 1.0),
        ):
            module.apply(lambda m, g=gain: self.init_weights(m, gain=g))
        start = math.log(math.expm1(deviation - _LEAST_DEVIATION))
        nn.init.constant_(self.deviation_net.bias, start)
        critic = [
            *self.mlp_extractor.value_net.parameters(),
            *self.value_net.parameters(),
        ]
        known = {id(p) for p in critic}
        actor = [p for p in self.parameters() if id(p) not in known]
        self.optimizers = tuple(
            ThresholdAdam(
                parameters,
                threshold=threshold,
                lr=lr_schedule(1),
                betas=(0.9, 0.999),
                eps=1e-8,
                weight_decay=l2,
            )
            for parameters, l2 in ((actor, actor_l2), (critic, critic_l2))
        )
        # Where stable-baselines3 looks for one.
        self.optimizer = self.optimizers[0]

    def Actor(
        self, observations: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and deviation of the actions (N, k)."""
        return self._spread_of(self.mlp_extractor.forward_actor(observations))

    def Critic(self, observations: torch.Tensor) -> torch.Tensor:
        """Values (N, 1)."""
        return self.value_net(self.mlp_extractor.forward_critic(observations))

    def _spread_of(
        self, latent: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        mean = torch.tanh(self.action_net(latent))
        raw = self.deviation_net(latent)
        deviation = nn.functional.softplus(raw) + _LEAST_DEVIATION
        return mean, deviation.clamp(max=self._largest)

    def _get_action_dist_from_latent(
        self, latent_pi: torch.Tensor
    ) -> Distribution:
        mean, deviation = self._spread_of(latent_pi)
        return self.action_dist.proba_distribution(mean, deviation.log())

    def layers(self) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Weights and biases of the mean's layers, as numpy has them."""
        linear = [
            m for m in self.mlp_extractor.policy_net if hasattr(m, "bias")
        ]
        linear.append(self.action_net)
        return (
            [m.weight.detach().numpy().copy() for m in linear],
            [m.bias.detach().numpy().copy() for m in linear],
        )

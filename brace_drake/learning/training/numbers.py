"""Hyper-parameters of a training run; the defaults are the paper's."""

from dataclasses import dataclass

from brace_drake.core.errors import ScenarioError


@dataclass
class TrainingNumbers:
    """Section 4.2 of the paper, but for what is marked [ours].

    Attributes:
        episodes: Budget, of `max_steps` decisions each.
        horizon: Decisions between updates, over all envs: the paper's
            experience horizon, of horizon / envs decisions of each episode.
        envs: Episodes side by side [ours]; on the diagram in processes of
            their own. Results depend on their number.
        gradient_threshold: Of the L2 norm of each parameter's gradient.
        start_deviation, largest_deviation: Of the actor's normal distribution
            [ours].
        scale_observations, scale_rewards: By their running deviation [ours].
        evaluate_every: Updates between evaluations, noise and randomness off
            [ours].
        evaluated_subjects: Of an evaluation, always the same: the nominal
            one, and where subjects are drawn the rest of their ranges [ours].
        patience: Evaluations without a better one that end a run; 0: never
            [ours].
        checkpoint_every: Updates between checkpoints [ours].
    """

    seed: int = 0
    episodes: int = 1000
    horizon: int = 512
    batch_size: int = 64
    epochs: int = 10
    gamma: float = 0.99
    gae_factor: float = 0.95
    clip: float = 0.2
    entropy_weight: float = 0.01
    learning_rate: float = 3e-4
    hidden: int = 256
    actor_l2: float = 1e-5
    critic_l2: float = 2e-4
    gradient_threshold: float = 1.0
    start_deviation: float = 0.5
    largest_deviation: float = 1.0
    envs: int = 1
    scale_observations: bool = True
    scale_rewards: bool = True
    evaluate_every: int = 10
    evaluated_subjects: int = 6
    patience: int = 0
    checkpoint_every: int = 1


_POSITIVE = (
    "episodes", "horizon", "batch_size", "epochs", "gamma", "learning_rate",
    "hidden", "gradient_threshold", "start_deviation", "largest_deviation",
    "envs", "evaluate_every", "evaluated_subjects", "checkpoint_every",
)  # fmt: skip


def check_training(numbers: TrainingNumbers) -> None:
    """Checks ranges.

    Raises:
        ScenarioError: Key, value, what is allowed.
    """
    for key in _POSITIVE:
        if not getattr(numbers, key) > 0:
            _fail(numbers, key, "greater than 0")
    for key in ("seed", "patience", "actor_l2", "critic_l2", "entropy_weight"):
        if not getattr(numbers, key) >= 0:
            _fail(numbers, key, "0 or more")
    for key in ("gamma", "gae_factor", "clip"):
        if not 0.0 <= getattr(numbers, key) <= 1.0:
            _fail(numbers, key, "0 to 1")
    if numbers.horizon % numbers.envs:
        _fail(numbers, "horizon", f"a multiple of envs, {numbers.envs}")
    if numbers.horizon // numbers.envs < 2:
        _fail(numbers, "horizon", "at least 2 for each env")


def _fail(numbers: TrainingNumbers, key: str, allowed: str) -> None:
    value = getattr(numbers, key)
    raise ScenarioError(f"training: {key}: {value!r}; allowed: {allowed}")

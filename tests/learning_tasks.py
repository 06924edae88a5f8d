"""Small tasks and policies for tests of learning."""

import numpy as np

from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.policy import Policy
from brace_drake.learning.task import LearningTask


def short_task(steps=6, **changes):
    """A motion as fast as the paper's, cut after a few decisions."""
    return LearningTask(max_steps=steps, **changes)


def random_policy(task=None, seed=0, hidden=16):
    """A policy whose actions differ from one decision to the next."""
    task = short_task() if task is None else task
    env, rng = RlpicEnv(task), np.random.default_rng(seed)
    sizes = [env.observation_space.shape[0], hidden, hidden]
    sizes.append(env.action_space.shape[0])
    pairs = list(zip(sizes[1:], sizes[:-1], strict=True))
    return Policy(
        weights=tuple(
            rng.normal(size=s).astype(np.float32) / np.float32(s[1]) ** 0.5
            for s in pairs
        ),
        biases=tuple(rng.normal(size=s[0]).astype(np.float32) for s in pairs),
        mean=rng.normal(scale=1e-3, size=sizes[0]),
        gain=10.0 ** rng.uniform(2, 4, sizes[0]),
        clip=10.0,
        law=env.law,
        selected=env.prepared.selected,
        task=task,
    )

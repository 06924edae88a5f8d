"""Makers of envs that pickle, for processes of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.limits import EpisodeLimits
from brace_drake.learning.rewards import RewardNumbers
from brace_drake.learning.task import LearningTask


def full_task() -> LearningTask:
    """Three rings pushed along y, equations (7) to (10) on 18 coordinates.

    Ring 2 goes the paper's 10 mm, its neighbours half as far; every coordinate
    counts alike, forces where they are measured.
    """
    displacement = np.zeros(18)
    displacement[[1, 7, 13]] = -0.005, -0.01, -0.005
    inf = np.inf
    return LearningTask(
        scenario="rlpic_full.scenario.yaml",
        observation="all",
        displacement=displacement,
        reward=RewardNumbers(
            position_weight=np.full(6, 2.0),
            velocity_weight=np.full(6, 2.0),
            force_weight=np.array([0.0, 2, 0, 0, 0, 0]),
        ),
        limits=EpisodeLimits(
            lower=np.array([-0.02, -0.4, -0.02, -0.2, -0.2, -0.2]),
            upper=np.array([0.02, 0.02, 0.02, 0.2, 0.2, 0.2]),
            speed=np.array([0.6, 0.6, 0.6, inf, inf, inf]),
            force=np.array([50.0, 50, 50, inf, inf, inf]),
        ),
    )


def make_env(
    task: LearningTask | None = None, render_mode: str | None = None
) -> RlpicEnv:
    """The env of a task; None: `BraceDrake/RLPIC-v0` as the paper has it."""
    return RlpicEnv(task, render_mode)


def make_full_env(
    task: LearningTask | None = None, render_mode: str | None = None
) -> RlpicEnv:
    """`BraceDrake/RLPIC-Full-v0`."""
    return RlpicEnv(full_task() if task is None else task, render_mode)


@dataclass(frozen=True)
class EnvMaker:
    """A function without arguments that makes a task's env; it pickles."""

    task: LearningTask

    def __call__(self) -> RlpicEnv:
        return RlpicEnv(self.task)

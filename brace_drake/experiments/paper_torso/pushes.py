"""The pushes of the table: PIC, the paper's constant, RLPIC; on each torso."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np

from brace_drake.experiments.paper_torso.lean import (
    LEANING,
    PAPER_STIFFNESS,
    leaning_task,
    run_push,
)
from brace_drake.experiments.rollouts import Benchmark, Controller, Rollout
from brace_drake.experiments.scores import Score
from brace_drake.learning.policy import Policy
from brace_drake.learning.task import LearningTask, load_task_scenario
from brace_drake.scenario.brace import BraceScenario

ALONE = "leaning torso, stage 2"
SPRING = "paper_pic.scenario.yaml"
_START_S = 1.0


@dataclass(frozen=True)
class PaperPush:
    """One row: who, on which torso, and what happened.

    Attributes:
        controller: pic, constant or rlpic.
        setting: The torso, and the stages.
        rollout: What happened.
        score: Its measures.
        start_velocity: Along y, the fastest of the first second with its
            sign, m/s.
    """

    controller: str
    setting: str
    rollout: Rollout
    score: Score
    start_velocity: float


def run_pushes(
    policy: Policy | None = None, leaning: BraceScenario | None = None
) -> list[PaperPush]:
    """Runs every row; the first are those that the figures show.

    Args:
        policy: Trained on the leaning torso; None: no row of RLPIC.
        leaning: Its scenario; None: the package's.
    """
    leaning = leaning or load_task_scenario(leaning_task())
    constant = Controller("constant", stiffness=PAPER_STIFFNESS)
    pic = Controller("pic")
    learned = [Controller("rlpic", policy=policy)] if policy else []
    alone = Benchmark(leaning_task(), leaning)
    spring = Benchmark(LearningTask(scenario=SPRING))
    rows = (
        (ALONE, alone, (pic, *learned, constant)),
        ("leaning torso, whole brace", _whole(leaning), (pic, constant)),
        ("posture spring, stage 2", spring, (pic, *learned, constant)),
    )
    return [
        _push(benchmark, controller, setting)
        for setting, benchmark, controllers in rows
        for controller in controllers
    ]


def whole_brace(leaning: BraceScenario) -> BraceScenario:
    """All three stages; ring 2 alone is pushed and meets the torso."""
    scenario = copy.deepcopy(leaning)
    scenario.stages = [1, 2, 3]
    scenario.contact.ring1.model = scenario.contact.ring3.model = "none"
    scenario.control.impedance.coordinates = ["y2"]
    scenario.control.inner.force_feedforward = ["y2"]
    return scenario


def _whole(leaning: BraceScenario) -> Benchmark:
    displacement = np.zeros(18)
    displacement[7] = leaning_task().displacement[1]
    task = LearningTask(
        scenario=LEANING, observation="all", displacement=displacement
    )
    return Benchmark(task, whole_brace(leaning))


def _push(
    benchmark: Benchmark, controller: Controller, setting: str
) -> PaperPush:
    rollout, score = run_push(benchmark, controller)
    rate = rollout.signals.rate[rollout.time <= _START_S, benchmark.pushed]
    fastest = float(rate[np.abs(rate).argmax()]) if len(rate) else np.nan
    return PaperPush(controller.name, setting, rollout, score, fastest)

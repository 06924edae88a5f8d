"""Policies beside controllers: the paper's Table 1, and subjects never seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import PolicyError
from brace_drake.core.parallel import Workers
from brace_drake.experiments.rollouts import (
    Benchmark,
    ConstantSearch,
    Controller,
    Rollout,
    TaskScore,
    search_constant,
)
from brace_drake.learning.policy import Policy
from brace_drake.learning.rewards import improved
from brace_drake.learning.subjects import (
    FACTORS,
    NOMINAL,
    Subject,
    SubjectRanges,
    between_patients,
    draw_subject,
)
from brace_drake.learning.task import LearningTask, load_task_scenario

TAGS = ("pic", "npic", "mraic", "vpic")
# Streams of subjects: those a constant is searched on, and those never seen.
_SEARCHED, _UNSEEN = 1, 2

# What policies have to share, beside the scenario.
_SHARED = (
    "observation", "sample_time", "max_steps", "displacement", "motion_time",
    "action",
)  # fmt: skip

Say = Callable[[str, float], None]


class NominalPush(NamedTuple):
    """A controller on the nominal subject."""

    controller: Controller
    rollout: Rollout
    score: TaskScore


@dataclass(frozen=True)
class Evaluation:
    """Everything that tables, figures and page show.

    Attributes:
        benchmark: On which all are compared.
        policies: Controllers with a policy; those of a name are its seeds.
        nominal: All controllers on the nominal subject.
        nominal_search: The constant stiffness of the best return on the
            nominal subject.
        nominal_sweep: Scores of constants on it, by stiffness.
        subjects: Never seen by any policy or search.
        unseen: Scores of each controller on each of them, by name: a row for
            each seed.
        search: The constant of the best return on subjects drawn apart from
            these.
        sweep: Scores of constants on the unseen subjects, by stiffness.
    """

    benchmark: Benchmark
    policies: tuple[Controller, ...]
    nominal: tuple[NominalPush, ...]
    nominal_search: ConstantSearch
    nominal_sweep: dict[float, TaskScore]
    subjects: tuple[Subject, ...]
    unseen: dict[str, list[list[TaskScore]]]
    search: ConstantSearch
    sweep: dict[float, list[TaskScore]]

    @property
    def policy_names(self) -> list[str]:
        """Each once."""
        return list(dict.fromkeys(c.name for c in self.policies))

    def on_nominal(self, name: str) -> list[TaskScore]:
        """Scores of a controller's seeds on the nominal subject."""
        return [p.score for p in self.nominal if p.controller.name == name]

    def collect(self, name: str, field: str) -> np.ndarray:
        """A measure of a controller (seeds, subjects)."""
        rows = self.unseen[name]
        return np.array([[getattr(s, field) for s in row] for row in rows])


def gather_policies(policies: Sequence[Policy]) -> tuple[Controller, ...]:
    """Policies as controllers: those of one task are seeds of one.

    Raises:
        PolicyError: They are not of the same motion on the same scenario.
    """
    tasks = [
        yaml_dump_typed(_compared(p.task))
        + yaml_dump_typed(load_task_scenario(p.task))
        for p in policies
    ]
    for i, text in enumerate(tasks):
        if text != tasks[0]:
            raise PolicyError(
                f"policy {i + 1}: of another scenario, motion, sample time or"
                " action than policy 1: they cannot be compared"
            )
    known: dict[str, list[int]] = {}
    for i, policy in enumerate(policies):
        text = yaml_dump_typed(replace(policy.task, scenario=""))
        known.setdefault(text, []).append(i)
    found, names = [], []
    for members in known.values():
        name = _name_of(policies[members[0]].task, names, len(known))
        names.append(name)
        found += [
            Controller(name, "vpic", policy=policies[i], seed=seed)
            for seed, i in enumerate(members)
        ]
    return tuple(found)


def _compared(task: LearningTask) -> LearningTask:
    """What policies have to share."""
    return replace(
        LearningTask(scenario=""),
        **{name: getattr(task, name) for name in _SHARED},
    )


def _name_of(task: LearningTask, taken: list[str], groups: int) -> str:
    if groups == 1:
        return "rlpic"
    drawn = "one subject" if is_single(task.subjects) else "drawn subjects"
    name = base = f"rlpic ({task.reward.kind} reward, {drawn})"
    while name in taken:
        name = f"{base} {2 + taken.count(name)}"
    return name


def is_single(ranges: SubjectRanges) -> bool:
    """Whether all subjects of the ranges are alike."""
    factors = all(np.ptp(getattr(ranges, name)) == 0.0 for name in FACTORS)
    return factors and not ranges.effects


def make_task(policies: Sequence[Controller]) -> LearningTask:
    """The task that all are measured on: motion, limits, and subjects.

    The subjects are those of the first policy that was trained on several, or
    0.7 to 1.5 times nominal; the reward is `improved` unless all policies
    share another.
    """
    tasks = [c.policy.task for c in policies]
    task = tasks[0] if tasks else LearningTask(reward=improved())
    wide = [t.subjects for t in tasks if not is_single(t.subjects)]
    rewards = {yaml_dump_typed(t.reward) for t in tasks}
    reward = task.reward if len(rewards) == 1 else improved()
    subjects = wide[0] if wide else between_patients()
    return replace(task, subjects=subjects, reward=reward)


def draw_subjects(
    ranges: SubjectRanges, count: int, seed: int, stream: int = _UNSEEN
) -> tuple[Subject, ...]:
    """Subjects of a seed; each is the same however many there are."""
    return tuple(
        draw_subject(ranges, np.random.default_rng([seed, stream, i]))
        for i in range(count)
    )


def evaluate(
    policies: Sequence[Controller],
    workers: Workers,
    num_subjects: int = 50,
    num_searched: int = 20,
    seed: int = 1,
    say: Say | None = None,
) -> Evaluation:
    """Runs everybody on the nominal and on unseen subjects; nothing is random.

    Args:
        policies: From `gather_policies`; may be none.
        workers: That share the pushes.
        num_subjects: Unseen ones.
        num_searched: Others, on which a constant stiffness is tuned.
        seed: Of both.
        say: For progress.

    Raises:
        PolicyError, ScenarioError: The task cannot be run.
    """
    say = say or (lambda what, share: None)
    benchmark = Benchmark(make_task(policies))
    ranges = benchmark.task.subjects
    say("constant stiffness, nominal", 0.0)
    own = search_constant(benchmark, (NOMINAL,), workers)
    others = draw_subjects(ranges, num_searched, seed, _SEARCHED)
    say("constant stiffness, drawn", 0.05)
    search = search_constant(benchmark, others, workers)
    fixed = [Controller(tag, tag) for tag in TAGS]

    def everybody(best: float) -> list[Controller]:
        return [*fixed, Controller("constant", stiffness=best), *policies]

    say("nominal subject", 0.3)
    named = everybody(own.best)
    rollouts = workers.map(benchmark.run, [(c, NOMINAL) for c in named])
    score = benchmark.run_and_score
    swept = [(Controller("", stiffness=K), NOMINAL) for K in own.tried]
    own_sweep = workers.map(score, swept)
    nominal = tuple(
        NominalPush(c, rollout, benchmark.score(rollout))
        for c, rollout in zip(named, rollouts, strict=True)
    )
    subjects = draw_subjects(ranges, num_subjects, seed)
    named = everybody(search.best)
    sweep = [Controller("", stiffness=K) for K in search.tried]
    tasks = [(c, s) for c in (*named, *sweep) for s in subjects]

    def told(done: int) -> None:
        say("unseen subjects", 0.35 + 0.65 * done / len(tasks))

    flat = workers.map(score, tasks, told)
    rows = [
        flat[i : i + len(subjects)] for i in range(0, len(flat), len(subjects))
    ]
    unseen: dict[str, list[list[TaskScore]]] = {}
    for controller, row in zip(named, rows, strict=False):
        unseen.setdefault(controller.name, []).append(row)
    return Evaluation(
        benchmark=benchmark,
        policies=tuple(policies),
        nominal=nominal,
        nominal_search=own,
        nominal_sweep=dict(zip(own.tried, own_sweep, strict=True)),
        subjects=subjects,
        unseen=unseen,
        search=search,
        sweep=dict(zip(search.tried, rows[len(named) :], strict=True)),
    )

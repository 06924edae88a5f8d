"""Policies beside controllers: the paper's Table 1, and subjects never seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import PolicyError
from brace_drake.core.parallel import Workers
from brace_drake.experiments.best_constant import Search, search_constant
from brace_drake.experiments.rollouts import Arena, Contestant, Rollout
from brace_drake.experiments.scores import Score, score_rollout
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

Say = Callable[[str, float], None]


@dataclass(frozen=True)
class Evaluation:
    """Everything that tables, figures and page show.

    Attributes:
        arena: Where all met.
        policies: Contestants with a policy; those of a name are its seeds.
        contestants: All of them on the nominal subject.
        nominal: Rollout of each of these.
        nominal_scores: The same.
        nominal_search: The constant stiffness of the best return on the
            nominal subject.
        nominal_sweep: Scores of constants on it, by stiffness.
        subjects: Never seen by any policy or search.
        unseen: Scores of each contestant on each of them, by name: a row for
            each seed.
        search: The constant of the best return on subjects drawn apart from
            these.
        sweep: Scores of constants on the unseen subjects, by stiffness.
    """

    arena: Arena
    policies: tuple[Contestant, ...]
    contestants: tuple[Contestant, ...]
    nominal: tuple[Rollout, ...]
    nominal_scores: tuple[Score, ...]
    nominal_search: Search
    nominal_sweep: dict[float, Score]
    subjects: tuple[Subject, ...]
    unseen: dict[str, list[list[Score]]]
    search: Search
    sweep: dict[float, list[Score]]

    def collect(self, name: str, field: str) -> np.ndarray:
        """A measure of a contestant (seeds, subjects)."""
        rows = self.unseen[name]
        return np.array([[getattr(s, field) for s in row] for row in rows])


def gather_policies(policies: Sequence[Policy]) -> tuple[Contestant, ...]:
    """Policies as contestants: those of one task are seeds of one.

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
    contestants, names = [], []
    for members in known.values():
        name = _name_of(policies[members[0]].task, names, len(known))
        names.append(name)
        contestants += [
            Contestant(name, "vpic", policy=policies[i], seed=seed)
            for seed, i in enumerate(members)
        ]
    return tuple(contestants)


def _compared(task: LearningTask) -> LearningTask:
    """What policies have to share."""
    plain = LearningTask()
    return replace(
        task,
        scenario="",
        reward=plain.reward,
        limits=plain.limits,
        subjects=plain.subjects,
        readings=plain.readings,
        backend=plain.backend,
        failure_reward=plain.failure_reward,
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


def make_task(policies: Sequence[Contestant]) -> LearningTask:
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
    policies: Sequence[Contestant],
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
        num_searched: Others, on which the best constant is searched.
        seed: Of both.
        say: For progress.

    Raises:
        PolicyError, ScenarioError: The task cannot be run.
    """
    say = say or (lambda what, share: None)
    arena = Arena(make_task(policies))
    ranges = arena.task.subjects
    say("best constant, nominal", 0.0)
    own = search_constant(arena, (NOMINAL,), workers)
    others = draw_subjects(ranges, num_searched, seed, _SEARCHED)
    say("best constant, drawn subjects", 0.05)
    search = search_constant(arena, others, workers)
    fixed = [Contestant(tag, tag) for tag in TAGS]
    best = Contestant("constant", "pic", stiffness=own.best)
    players = (*fixed, best, *policies)
    say("nominal subject", 0.3)
    nominal = workers.map(arena.run, [(c, NOMINAL) for c in players])
    swept = [Contestant("", "pic", stiffness=K) for K in own.tried]
    own_sweep = workers.map(run_and_score, [(arena, c, NOMINAL) for c in swept])
    subjects = draw_subjects(ranges, num_subjects, seed)
    best = Contestant("constant", "pic", stiffness=search.best)
    sweep = [Contestant(f"{K:g}", "pic", stiffness=K) for K in search.tried]
    unseen_players = [*fixed, best, *policies, *sweep]
    tasks = [(arena, c, s) for c in unseen_players for s in subjects]

    def told(done: int) -> None:
        say("unseen subjects", 0.35 + 0.65 * done / len(tasks))

    flat = workers.map(run_and_score, tasks, told)
    rows = [
        flat[i : i + len(subjects)] for i in range(0, len(flat), len(subjects))
    ]
    unseen: dict[str, list[list[Score]]] = {}
    named = len(unseen_players) - len(sweep)
    for contestant, row in zip(unseen_players[:named], rows, strict=False):
        unseen.setdefault(contestant.name, []).append(row)
    return Evaluation(
        arena=arena,
        policies=tuple(policies),
        contestants=players,
        nominal=tuple(nominal),
        nominal_scores=tuple(score_rollout(arena, r) for r in nominal),
        nominal_search=own,
        nominal_sweep=dict(zip(own.tried, own_sweep, strict=True)),
        subjects=subjects,
        unseen=unseen,
        search=search,
        sweep=dict(zip(search.tried, rows[named:], strict=True)),
    )


def run_and_score(
    arena: Arena, contestant: Contestant, subject: Subject
) -> Score:
    """The measures of one push."""
    return score_rollout(arena, arena.run(contestant, subject))

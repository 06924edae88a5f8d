"""A policy of the nominal twin beside one of the repaired twin.

Both are run on the independent simulator of the bench that recorded the
campaign from which the repair was made. What they differ by there is what
closing the gap was worth.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import BraceError
from brace_drake.core.output import (
    HoldFolder,
    MakeFolder,
    WriteJson,
    WriteText,
)
from brace_drake.core.parallel import Workers
from brace_drake.core.resources import scenario_path
from brace_drake.diagnosis import diagnose
from brace_drake.document.document import MakeDocument
from brace_drake.experiments.scores import Push, Score, score_push
from brace_drake.experiments.transfer.bench_push import push_bench
from brace_drake.learning.policy import LoadPolicy, Policy
from brace_drake.learning.rewards import improved
from brace_drake.learning.subjects import EffectRange, SubjectRanges
from brace_drake.learning.task import LearningTask
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.recording.columns import BRACE
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import LoadRecord, LoadScenario, SaveScenario
from brace_drake.validation.repaired import FILE, MakeRepairedScenario
from brace_drake.withheld.cases import Case, draw_background, draw_subject
from brace_drake.withheld.faults import FAULTS, SEVERITIES
from brace_drake.withheld.make import record_campaign
from brace_drake.withheld.simulator import make_motions

# Streams of chance of a seed: campaigns, pushes.
_RECORDED, _PUSHED = 1, 2
CAUSES = ("coulomb_friction", "command_delay", "relaxation")
# Trains a policy on a task in a folder; its file.
Train = Callable[[Path, LearningTask], Path]
Say = Callable[[str], None]
OPTIONS = "payoff.yaml"


@dataclass
class TransferOptions:
    """Options that machines, diagnoses and trainings of a folder depend on.

    Budget and seed of the trainings are kept by these themselves. Causes may
    be added, and pushes are made anew each time.

    Attributes:
        severity: Of the faults: small, medium or large.
        force_limit: F_max of the reward and of the measures, N. The bench's
            subject is stiffer than the paper's, and feels more than its 4 N
            from the start.
        seed: Of machines, campaigns, diagnoses and pushes.
    """

    severity: str = "large"
    force_limit: float = 20.0
    seed: int = 0


@dataclass(frozen=True)
class Outcome:
    """What one controller does on one machine in one push.

    Attributes:
        cause: What is wrong with the machine.
        controller: pic, nominal or repaired: the twin of its policy.
        number: Which of its pushes; those of a number have the same chance.
        score: Of the push.
        over_force: Share of the time above F_max.
    """

    cause: str
    controller: str
    number: int
    score: Score
    over_force: float


def KeepOptions(folder: Path, options: TransferOptions) -> None:
    """Writes payoff.yaml into a new folder, or holds the options to its own.

    Raises:
        BraceError: The folder was begun with others, or holds something that
            is not of this experiment.
    """
    path = folder / OPTIONS
    if not path.exists():
        if any(folder.iterdir()):
            raise BraceError(
                f"{folder}: holds files and no {OPTIONS}: name a new folder"
            )
        WriteText(path, yaml_dump_typed(options))
        return
    kept = vars(LoadRecord(TransferOptions(), path))
    for key, value in vars(options).items():
        if kept[key] != value:
            raise BraceError(
                f"{path}: {key}: begun with {kept[key]}, asked for is {value}:"
                " name another folder, or the same options"
            )


def make_case(cause: str, severity: str, seed: int) -> Case:
    """A machine with one fault, and its subject.

    Raises:
        BraceError: No such fault.
    """
    names = [fault.name for fault in FAULTS]
    if cause not in names:
        raise BraceError(f"cause {cause!r}; allowed: {', '.join(names)}")
    fault = FAULTS[names.index(cause)]
    rng = np.random.default_rng([seed, names.index(cause)])
    strength = fault.strengths[SEVERITIES.index(severity)]
    subject, background = draw_subject(rng), draw_background(rng)
    changes = {cause: fault.make(rng, strength)}
    return Case("single", (fault,), severity, subject, background, changes)


def repair_twin(
    case: Case, folder: Path, seed: int, workers: Workers
) -> BenchScenario:
    """Records a campaign of the machine, diagnoses it, repairs the twin.

    Without an effect in the verdict the twin is the fitted one.
    """
    recorded = folder / "campaign"
    if not recorded.exists():
        rng = np.random.default_rng([seed, _RECORDED])
        campaign = record_campaign(case, make_motions(rng), folder.name, rng)
        WriteCampaign(campaign, recorded)
    found = diagnose(LoadCampaign(recorded), workers, seed)
    WriteJson(folder / "diagnosis.json", MakeDocument(found))
    twin, winner = found.device.twin, found.verdict.winner
    if winner is None:
        return twin.scenario_of(found.nominal.subject)
    return MakeRepairedScenario(twin, winner)


def MakeBenchTask(
    bench: BenchScenario, file: Path, force_limit: float = 4.0
) -> LearningTask:
    """The paper's push on a bench, nominal or repaired, as a task to learn.

    Args:
        bench: With the effects that it carries: every subject has them.
        file: Where the brace that has its numbers is written.
        force_limit: F_max of the reward, which is the improved one, N.
    """
    control = replace(bench.control, tag="vpic")
    brace = replace(bench, device=BRACE, control=control, effects=[])
    SaveScenario(brace, file)
    effects = [
        EffectRange(
            name=use.name,
            form=use.form,
            parameters={k: np.full(2, v) for k, v in use.parameters.items()},
        )
        for use in bench.effects
    ]
    limits = np.full(6, float(force_limit))
    return LearningTask(
        scenario=str(file),
        reward=replace(improved(), force_limit=limits),
        readings="noisy",
        subjects=SubjectRanges(effects=effects),
    )


def compare_on_machine(
    case: Case,
    cause: str,
    policies: dict[str, Policy | None],
    options: TransferOptions,
    pushes: int,
    workers: Workers,
) -> list[Outcome]:
    """Pushes the machine under each controller, with the same chance."""
    seeds = [(options.seed, _PUSHED, i) for i in range(pushes)]
    tasks = [
        (case.subject, case.flaws, policy, -0.01, 12.0, seed)
        for policy in policies.values()
        for seed in seeds
    ]
    done: Iterator[Push] = iter(workers.map(push_bench, tasks))
    outcomes = []
    for name in policies:
        for i in range(pushes):
            push = next(done)
            over = float(np.mean(np.abs(push.force) > options.force_limit))
            outcomes.append(Outcome(cause, name, i, score_push(push), over))
    return outcomes


def run_transfer(
    folder: Path,
    train: Train,
    workers: Workers,
    options: TransferOptions,
    causes: Sequence[str] = CAUSES,
    pushes: int = 3,
    say: Say | None = None,
) -> list[Outcome]:
    """The whole experiment; what a folder has already is not made again.

    Args:
        folder: For campaigns, diagnoses, trainings and policies.
        train: Makes a policy.
        workers: For diagnoses and pushes.
        options: That the folder is held to.
        causes: One machine each.
        pushes: Of each controller on each machine.
        say: Told what is being done.

    Raises:
        BraceError: No such cause, the folder is of other options, or a step
            failed.
    """
    say = say or (lambda what: None)
    names = list(dict.fromkeys(c.strip() for c in causes if c.strip()))
    # A word that is wrong is told before anything takes its time.
    cases = {n: make_case(n, options.severity, options.seed) for n in names}
    if not cases:
        raise BraceError("no cause is named")
    folder = HoldFolder(Path(folder))
    KeepOptions(folder, options)

    def policy_of(own: Path, bench: BenchScenario) -> Policy:
        MakeFolder(own)
        file = own / "brace.scenario.yaml"
        task = MakeBenchTask(bench, file, options.force_limit)
        return LoadPolicy(train(own / "training", task))

    nominal = LoadScenario(scenario_path("bench.scenario.yaml"))
    say("training on the nominal twin")
    first = policy_of(folder / "nominal", nominal)
    outcomes = []
    for cause, case in cases.items():
        own = MakeFolder(folder / cause)
        if not (own / FILE).exists():
            say(f"{cause}: diagnosis")
            scenario = repair_twin(case, own, options.seed, workers)
            SaveScenario(scenario, own / FILE)
        say(f"{cause}: training on the repaired twin")
        repaired = policy_of(own, LoadScenario(own / FILE))
        policies = {"pic": None, "nominal": first, "repaired": repaired}
        say(f"{cause}: pushes of the machine")
        outcomes += compare_on_machine(
            case, cause, policies, options, pushes, workers
        )
    return outcomes

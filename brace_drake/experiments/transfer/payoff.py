"""A policy of the nominal twin beside one of the repaired twin.

Both are run on the independent simulator of the bench that recorded the
campaign from which the repair was made. What they differ by there is what
closing the gap was worth.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.core.output import HoldFolder, MakeFolder, WriteJson
from brace_drake.core.parallel import Workers
from brace_drake.core.resources import scenario_path
from brace_drake.diagnose import Diagnosis, diagnose
from brace_drake.document.document import MakeDocument
from brace_drake.experiments.measures import rms
from brace_drake.experiments.transfer.bench_task import MakeBenchTask
from brace_drake.experiments.transfer.on_simulator import (
    PhysicalPush,
    push_bench,
)
from brace_drake.experiments.transfer.payoff_options import (
    KeepOptions,
    PayoffOptions,
)
from brace_drake.learning.policy import LoadPolicy, Policy
from brace_drake.learning.task import LearningTask
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.load import LoadScenario, SaveScenario
from brace_drake.validation.repaired import FILE, MakeRepairedScenario
from brace_drake.withheld.cases import Case, draw_decoy, draw_subject
from brace_drake.withheld.faults import FAULTS, SEVERITIES
from brace_drake.withheld.make import record_campaign
from brace_drake.withheld.simulator import make_motions, with_flaws

# Streams of chance of a seed: campaigns, pushes.
_RECORDED, _PUSHED = 1, 2
CAUSES = ("coulomb_friction", "command_delay", "relaxation")
# Trains a policy on a task in a folder; its file.
Train = Callable[[Path, LearningTask], Path]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Outcome:
    """What one controller does on one machine in one push.

    Attributes:
        cause: What is wrong with the machine.
        controller: pic, nominal or repaired: the twin of its policy.
        push: Which of its pushes; those of a number have the same chance.
        y_rms, vy_rms: Error along y, m and m/s.
        across_rms: Error along x and z, m.
        peak_force: Greatest force, N.
        over_force: Share of the time above F_max.
        stiffness: Mean over the second half, N/m.
    """

    cause: str
    controller: str
    push: int
    y_rms: float
    vy_rms: float
    across_rms: float
    peak_force: float
    over_force: float
    stiffness: float


def make_case(cause: str, severity: str, seed: int) -> Case:
    """A machine with one fault, and its wearer.

    Raises:
        BraceError: No such fault.
    """
    found = [f for f in FAULTS if f.name == cause]
    if not found:
        names = ", ".join(f.name for f in FAULTS)
        raise BraceError(f"cause {cause!r}; allowed: {names}")
    rng = np.random.default_rng([seed, FAULTS.index(found[0])])
    strength = found[0].strengths[SEVERITIES.index(severity)]
    subject, decoy = draw_subject(rng), draw_decoy(rng)
    change = found[0].make(rng, strength)
    flaws = with_flaws(decoy, change)
    kind = "single"
    return Case(
        kind, (found[0],), severity, subject, decoy, flaws, {cause: change}
    )


def repair_twin(
    case: Case, folder: Path, seed: int, workers: Workers
) -> tuple[BenchScenario, Diagnosis]:
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
    if found.verdict.winner is None:
        return found.device.twin.scenario_of(found.nominal.subject), found
    return MakeRepairedScenario(found), found


def measure_push(
    push: PhysicalPush, cause: str, controller: str, number: int, limit: float
) -> Outcome:
    """Measures of one push."""
    error = push.desired - push.position[:, 1]
    settled = push.stiffness[len(push.stiffness) // 2 :]
    return Outcome(
        cause=cause,
        controller=controller,
        push=number,
        y_rms=rms(error),
        vy_rms=rms(push.desired_rate - push.rate),
        across_rms=rms(np.linalg.norm(push.position[:, [0, 2]], axis=1)),
        peak_force=float(np.abs(push.force).max()),
        over_force=float(np.mean(np.abs(push.force) > limit)),
        stiffness=float(settled.mean()),
    )


def compare_on_machine(
    case: Case,
    cause: str,
    policies: dict[str, Policy | None],
    limit: float,
    pushes: int,
    workers: Workers,
    seed: int = 0,
) -> list[Outcome]:
    """Pushes the machine under each controller, with the same chance."""
    tasks = [
        (case.subject, case.flaws, policy, -0.01, 12.0, (seed, _PUSHED, i))
        for policy in policies.values()
        for i in range(pushes)
    ]
    done = iter(workers.map(push_bench, tasks))
    return [
        measure_push(next(done), cause, name, i, limit)
        for name in policies
        for i in range(pushes)
    ]


def run_payoff(
    folder: Path,
    train: Train,
    workers: Workers,
    causes: Sequence[str] = CAUSES,
    severity: str = "large",
    force_limit: float = 20.0,
    pushes: int = 3,
    seed: int = 0,
    say: Say | None = None,
) -> list[Outcome]:
    """The whole experiment; what a folder has already is not made again.

    Args:
        folder: For campaigns, diagnoses, trainings and policies.
        train: Makes a policy.
        workers: For diagnoses and pushes.
        causes: One machine each.
        severity: small, medium or large.
        force_limit: F_max of the reward and of the measures, N.
        pushes: Of each controller on each machine.
        seed: Of machines, campaigns, diagnoses and pushes.
        say: Told what is being done.

    Raises:
        BraceError: No such cause, the folder is of other options, or a step
            failed.
    """
    say = say or (lambda what: None)
    names = list(dict.fromkeys(c.strip() for c in causes if c.strip()))
    # A word that is wrong is told before anything takes its time.
    cases = {name: make_case(name, severity, seed) for name in names}
    if not cases:
        raise BraceError("no cause is named")
    folder = HoldFolder(Path(folder))
    KeepOptions(folder, PayoffOptions(severity, force_limit, seed))
    nominal = LoadScenario(scenario_path("bench.scenario.yaml"))
    say("training on the nominal twin")
    first = _policy_of(folder / "nominal", nominal, force_limit, train)
    outcomes = []
    for cause, case in cases.items():
        own = MakeFolder(folder / cause)
        if not (own / FILE).exists():
            say(f"{cause}: diagnosis")
            scenario, _ = repair_twin(case, own, seed, workers)
            SaveScenario(scenario, own / FILE)
        say(f"{cause}: training on the repaired twin")
        repaired = LoadScenario(own / FILE)
        policies = {
            "pic": None,
            "nominal": first,
            "repaired": _policy_of(own, repaired, force_limit, train),
        }
        say(f"{cause}: pushes of the machine")
        outcomes += compare_on_machine(
            case, cause, policies, force_limit, pushes, workers, seed
        )
    return outcomes


def _policy_of(
    folder: Path, bench: BenchScenario, force_limit: float, train: Train
) -> Policy:
    MakeFolder(folder)
    task = MakeBenchTask(bench, folder / "brace.scenario.yaml", force_limit)
    return LoadPolicy(train(folder / "training", task))

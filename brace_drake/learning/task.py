"""What an agent is to do: every number of it, in one picklable record."""

import copy
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.core.resources import scenario_path
from brace_drake.learning.actions import ActionLaw, ActionNumbers
from brace_drake.learning.rewards import EpisodeLimits, RewardNumbers
from brace_drake.learning.signals import OBSERVERS
from brace_drake.learning.subjects import SubjectRanges, check_ranges
from brace_drake.recording.columns import BRACE
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.control_numbers import parse_coordinates, spread
from brace_drake.scenario.fields import check_fields, fail, number, vector, word
from brace_drake.scenario.load import LoadScenario

BACKENDS = ("compiled", "diagram")
READINGS = ("exact", "noisy")
# Of an episode.
LONGEST_S = 3600.0


@dataclass
class LearningTask:
    """An episode of RLPIC; the defaults are the paper's, section 4.2.

    Attributes:
        scenario: File of a brace, or the name of one of the package's.
        observation: `stage`, the paper's seven numbers of one ring, or `all`.
        sample_time: Between decisions, s; whole control periods.
        max_steps: Decisions in an episode.
        displacement: What the cubic motion adds to the start, of one ring (6,)
            or of all (6n,), m and rad.
        motion_time: Of that motion, s.
        readings: `exact`, or `noisy`: the policy sees what instruments read.
        failure_reward: Of a step that ends in a failure of the simulation.
        backend: `compiled` or `diagram`: the same laws, see the package.
    """

    scenario: str = "rlpic.scenario.yaml"
    observation: str = word(*OBSERVERS)
    sample_time: float = number(0.05, "s", least=1e-6, most=10.0)
    max_steps: int = number(240, least=1, most=1_000_000)
    displacement: np.ndarray = vector(
        0, -0.01, 0, 0, 0, 0, unit="m or rad", least=-1.0, most=1.0, per_ring=6
    )
    motion_time: float = number(12.0, "s", least=1e-3, most=LONGEST_S)
    readings: str = word(*READINGS)
    failure_reward: float = number(0.0, least=-1e6, most=1e6)
    backend: str = word(*BACKENDS)
    action: ActionNumbers = field(default_factory=ActionNumbers)
    reward: RewardNumbers = field(default_factory=RewardNumbers)
    limits: EpisodeLimits = field(default_factory=EpisodeLimits)
    subjects: SubjectRanges = field(default_factory=SubjectRanges)


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


# A policy names a scenario, and no other file of the computer.
_SUFFIXES = (".yaml", ".yml")


def _check_name(name: str, source: str) -> None:
    """Refuses what is no name of a scenario."""
    if Path(name).suffix not in _SUFFIXES:
        allowed = f"a name that ends in {' or '.join(_SUFFIXES)}"
        fail(source, "scenario", name, allowed)


def load_task_scenario(task: LearningTask) -> BraceScenario:
    """The scenario of a task, its controller the variable stiffness.

    Raises:
        ScenarioError: It cannot be read, or is none that can be learnt on.
    """
    path = Path(task.scenario)
    _check_name(task.scenario, "task")
    if not path.exists() and path.parent == Path("."):
        path = scenario_path(task.scenario)
    scenario = LoadScenario(path)
    found = {"device": scenario.device}
    if scenario.device == BRACE:
        found["mechanism"] = scenario.mechanism
        found["torso.present"] = scenario.torso.present
    needed = BRACE, "task_space", True
    for (key, value), allowed in zip(found.items(), needed, strict=False):
        if value != allowed:
            raise ScenarioError(
                f"{path}: {key}: {value!r}; allowed: {allowed!r}"
            )
    scenario.control.tag = "vpic"
    return scenario


def check_numbers(task: LearningTask, num_rings: int, source: str) -> None:
    """Checks every field of a task by itself.

    Args:
        task: The task.
        num_rings: Of the brace it is for.
        source: Named in the error.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
        EffectError: An effect of the subjects is none.
    """
    check_fields(task, source, num_rings=num_rings)
    _check_name(task.scenario, source)
    if task.max_steps * task.sample_time > LONGEST_S:
        allowed = f"episodes of at most {LONGEST_S:g} s"
        fail(source, "max_steps", task.max_steps, allowed)
    if task.observation == "stage" and num_rings != 1:
        allowed = f"all, as the brace has {num_rings} stages"
        fail(source, "observation", "stage", allowed)
    if not (task.limits.lower < task.limits.upper).all():
        allowed = "less than limits.upper"
        fail(source, "limits.lower", task.limits.lower, allowed)
    if num_rings > 1 and task.subjects.effects:
        number = len(task.subjects.effects)
        fail(source, "subjects.effects", number, f"none: {num_rings} stages")
    check_ranges(task.subjects, f"{source}: subjects")


def check_task(
    task: LearningTask, scenario: BraceScenario, source: str = "task"
) -> None:
    """Checks a task against its scenario.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
        EffectError: An effect of the subjects is none.
    """
    check_numbers(task, len(scenario.stages), source)
    period = 1.0 / scenario.control.rate
    ticks = task.sample_time / period
    if not (round(ticks) >= 1 and abs(ticks - round(ticks)) < 1e-6):
        allowed = f"whole periods of {period:g} s"
        fail(source, "sample_time", task.sample_time, allowed)
    models = [c.model for c in scenario.contacts]
    if task.backend == "compiled" and "hydroelastic" in models:
        allowed = "diagram, where contact is hydroelastic"
        fail(source, "backend", "compiled", allowed)
    _check_friction(task, scenario)


def _check_friction(task: LearningTask, scenario: BraceScenario) -> None:
    """Checks that a plant step is stable on the stiffest subject's pads.

    Their regularised friction mu N / v_s is explicit in a step: it is stable
    where dt mu N / v_s is less than the ring's mass, N that of both pads.
    """
    most = task.subjects.contact_stiffness[1] * task.subjects.preload[1]
    for name, pads in zip(scenario.rings, scenario.contacts, strict=True):
        drag = pads.friction / pads.friction_regularization
        N = 2.0 * pads.stiffness * pads.preload * most
        if pads.model != "linear" or drag * N == 0.0:
            continue
        longest = scenario.ring.mass / (drag * N)
        if not scenario.time_step < longest:
            raise ScenarioError(
                f"{task.scenario}: time_step: {scenario.time_step!r}; allowed:"
                f" less than {longest:.3g} s, or the friction of {name}'s pads"
                " is not stable on the stiffest subject"
            )


def spread_task(task: LearningTask, num_rings: int) -> LearningTask:
    """A copy whose arrays of one ring have become those of all rings."""
    task = copy.deepcopy(task)
    task.displacement = spread(task.displacement, num_rings)
    for part in (task.reward, task.limits):
        for key in _arrays_of(part):
            setattr(part, key, spread(getattr(part, key), num_rings))
    return task


def make_action_law(task: LearningTask, scenario: BraceScenario) -> ActionLaw:
    """Bounds of the scenario and rate of the task as one law.

    Actions are of the coordinates with an impedance, in their order.
    """
    control, n = scenario.control, len(scenario.stages)
    rest = spread(control.impedance.stiffness, n, 3)
    on = parse_coordinates(control.impedance.coordinates, n) != 0.0
    lower, upper = control.vpic.lower, control.vpic.upper
    return ActionLaw(
        lower=lower,
        upper=upper,
        start=np.clip(rest[on], lower, upper),
        scale=task.action.scale,
        largest=task.action.rate * task.sample_time,
    )


def _arrays_of(part) -> list[str]:
    return [k for k, v in vars(part).items() if isinstance(v, np.ndarray)]

"""What an agent is to do: every number of it, in one picklable record."""

import copy
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.core.resources import scenario_path
from brace_drake.learning.actions import SCALES, ActionLaw, ActionNumbers
from brace_drake.learning.rewards import EpisodeLimits, RewardNumbers, vector
from brace_drake.learning.signals import OBSERVERS
from brace_drake.learning.subjects import SubjectRanges, check_ranges
from brace_drake.recording.columns import BRACE
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.control_numbers import parse_coordinates, spread
from brace_drake.scenario.load import LoadScenario

BACKENDS = ("compiled", "diagram")
READINGS = ("exact", "noisy")


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
    observation: str = "stage"
    sample_time: float = 0.05
    max_steps: int = 240
    displacement: np.ndarray = vector(0, -0.01, 0, 0, 0, 0)
    motion_time: float = 12.0
    readings: str = "exact"
    failure_reward: float = 0.0
    backend: str = "compiled"
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


def load_task_scenario(task: LearningTask) -> BraceScenario:
    """The scenario of a task, its controller the variable stiffness.

    Raises:
        ScenarioError: It cannot be read, or is none that can be learnt on.
    """
    path = Path(task.scenario)
    if path.suffix not in _SUFFIXES:
        raise ScenarioError(
            f"task: scenario: {task.scenario!r}; allowed: a name that ends in"
            f" {' or '.join(_SUFFIXES)}"
        )
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


def check_task(task: LearningTask, scenario: BraceScenario) -> None:
    """Checks a task against its scenario.

    Raises:
        ScenarioError: One line: key path, value, what is allowed.
        EffectError: An effect of the subjects is none.
    """
    n = len(scenario.stages)
    period = 1.0 / scenario.control.rate
    words = (
        ("observation", task.observation, tuple(OBSERVERS)),
        ("readings", task.readings, READINGS),
        ("backend", task.backend, BACKENDS),
        ("reward.kind", task.reward.kind, ("paper", "barrier")),
        ("action.scale", task.action.scale, SCALES),
    )
    for key, value, allowed in words:
        if value not in allowed:
            _fail(key, value, " or ".join(allowed))
    ticks = task.sample_time / period
    if not (round(ticks) >= 1 and abs(ticks - round(ticks)) < 1e-6):
        _fail("sample_time", task.sample_time, f"whole periods of {period:g} s")
    for key, value in (
        ("motion_time", task.motion_time),
        ("max_steps", task.max_steps),
        ("action.rate", task.action.rate),
    ):
        if not value > 0:
            _fail(key, value, "greater than 0")
    if task.observation == "stage" and n != 1:
        _fail("observation", "stage", f"all, as the brace has {n} stages")
    if not 0.0 <= task.reward.barrier_share < 1.0:
        _fail("reward.barrier_share", task.reward.barrier_share, "0 to 1")
    for holder, key in (
        (task, "displacement"),
        *((task.reward, k) for k in _arrays_of(task.reward)),
        *((task.limits, k) for k in _arrays_of(task.limits)),
    ):
        size = np.shape(getattr(holder, key))
        if size not in ((6,), (6 * n,)):
            _fail(key, list(size), f"6 or {6 * n} numbers")
    models = [c.model for c in scenario.contacts]
    if task.backend == "compiled" and "hydroelastic" in models:
        _fail("backend", "compiled", "diagram, where contact is hydroelastic")
    if n > 1 and task.subjects.effects:
        _fail("subjects.effects", len(task.subjects.effects), "none: 3 stages")
    check_ranges(task.subjects)
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


def _fail(key: str, value, allowed: str) -> None:
    raise ScenarioError(f"task: {key}: {value!r}; allowed: {allowed}")

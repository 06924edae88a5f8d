"""The whole brace's scenario: three stages, or those that `stages` picks."""

from dataclasses import dataclass, field

import numpy as np

from brace_drake.scenario.bench import (
    Contact,
    JointCircle,
    Leg,
    Ring,
    Sensors,
    Torso,
)
from brace_drake.scenario.controllers import BraceControl

DEVICE = "brace"


def _vector(*values: float):
    return field(default_factory=lambda: np.array(values, dtype=float))


def _joints(lower_radius, lower_deg, upper_radius, upper_deg):
    return field(
        default_factory=lambda: StageJoints(
            JointCircle(lower_radius, np.array(lower_deg, dtype=float)),
            JointCircle(upper_radius, np.array(upper_deg, dtype=float)),
        )
    )


_LOWER, _UPPER = (-13, 13, 107, 133, 227, 253), (-47, 47, 73, 167, 193, 287)


@dataclass
class StageJoints:
    """Joint circles of a stage; leg k joins lower to upper angle k."""

    lower: JointCircle = field(default_factory=JointCircle)
    upper: JointCircle = field(default_factory=JointCircle)


@dataclass
class BraceJoints:
    """Joint circles of stage i, on ring i - 1 below and ring i above."""

    stage1: StageJoints = _joints(0.20, _LOWER, 0.19, _UPPER)
    stage2: StageJoints = _joints(0.19, _LOWER, 0.18, _UPPER)
    stage3: StageJoints = _joints(
        0.18, (-10, 10, 110, 130, 230, 250), 0.17, (-50, 50, 70, 170, 190, 290)
    )


@dataclass
class BraceRing(Ring):
    """A moving ring, about its centre, half of each adjoining leg lumped in.

    The articulated brace, whose legs have their own masses, takes these halves
    off again.
    """

    half_axes: np.ndarray = _vector(0.205, 0.205)  # m, x and y, for drawing


@dataclass
class BraceLeg(Leg):
    """A linear drive of tube, on the ring below, and rod, on that above.

    Both are taken as uniform cylinders as long as the closed leg.
    """

    stroke: float = 0.050  # m, centred on the length at rest
    tube_mass: float = 0.056  # kg
    rod_mass: float = 0.030  # kg
    tube_radius: float = 0.009  # m
    rod_radius: float = 0.004  # m


@dataclass
class WorkspaceLimits:
    """What a pose of the brace has to keep to, beside the strokes.

    The smallest singular value of a stage's leg Jacobian, rotation scaled by
    the radius of its upper joints; 0 is a singularity.
    """

    singular_value: float = 0.3


@dataclass
class RingContacts:
    """Pads of each moving ring: `none`, `linear` or `hydroelastic`."""

    ring1: Contact = field(default_factory=Contact)
    ring2: Contact = field(default_factory=Contact)
    ring3: Contact = field(default_factory=Contact)


@dataclass
class StartPoses:
    """Each ring's pose at time 0: displacement, m, rotation vector, rad."""

    ring1: np.ndarray = _vector(0, 0, 0, 0, 0, 0)
    ring2: np.ndarray = _vector(0, 0, 0, 0, 0, 0)
    ring3: np.ndarray = _vector(0, 0, 0, 0, 0, 0)


@dataclass
class BraceScenario:
    """Stacked stages with torso, contact, drives and instruments."""

    device: str = DEVICE
    mechanism: str = "task_space"  # or articulated
    stages: list[int] = field(default_factory=lambda: [1, 2, 3])
    time_step: float = 0.0005  # s, of the plant
    gravity: float = 9.81  # m/s^2
    ring_heights: np.ndarray = _vector(0.0, 0.145, 0.235, 0.295)  # m, in W
    joints: BraceJoints = field(default_factory=BraceJoints)
    ring: BraceRing = field(default_factory=BraceRing)
    leg: BraceLeg = field(default_factory=BraceLeg)
    workspace: WorkspaceLimits = field(default_factory=WorkspaceLimits)
    start: StartPoses = field(default_factory=StartPoses)
    torso: Torso = field(default_factory=Torso)
    contact: RingContacts = field(default_factory=RingContacts)
    control: BraceControl = field(default_factory=BraceControl)
    sensors: Sensors = field(default_factory=Sensors)

    @property
    def rings(self) -> tuple[str, ...]:
        """Names of the moving rings, bottom to top."""
        return tuple(f"ring{i}" for i in self.stages)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Of each moving ring, bottom to top."""
        return tuple(getattr(self.contact, name) for name in self.rings)

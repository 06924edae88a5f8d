"""The scenario of a brace: every number of the twin, with unit and limits.

A bench is a brace of which one stage moves. [P] stated in the paper; the
sources of all numbers stand in `diagrams/brace.scenario.yaml`.
"""

from dataclasses import dataclass, field

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.stage_cards import stage_cards
from brace_drake.recording.columns import BENCH, BRACE
from brace_drake.scenario.controllers import BraceControl
from brace_drake.scenario.fields import items, number, vector, word
from brace_drake.scenario.tolerances import Tolerances

_LOWER, _UPPER = (-13, 13, 107, 133, 227, 253), (-47, 47, 73, 167, 193, 287)


@dataclass(slots=True)
class JointCircle:
    """Anchors on a circle of a ring: angles from x towards y."""

    radius: float = number(0.19, "m", above=0.0)
    angles_deg: np.ndarray = vector(*_LOWER, unit="degrees")


@dataclass(slots=True)
class StageJoints:
    """Joint circles of a stage; leg k joins lower to upper angle k."""

    lower: JointCircle = field(default_factory=JointCircle)
    upper: JointCircle = field(default_factory=JointCircle)


def _joints(lower_radius, lower_deg, upper_radius, upper_deg):
    return field(
        default_factory=lambda: StageJoints(
            JointCircle(lower_radius, np.array(lower_deg, dtype=float)),
            JointCircle(upper_radius, np.array(upper_deg, dtype=float)),
        )
    )


@dataclass(slots=True)
class BraceJoints:
    """Joint circles of stage i, on ring i - 1 below and ring i above."""

    stage1: StageJoints = _joints(0.20, _LOWER, 0.19, _UPPER)
    stage2: StageJoints = _joints(0.19, _LOWER, 0.18, _UPPER)
    stage3: StageJoints = _joints(
        0.18, (-10, 10, 110, 130, 230, 250), 0.17, (-50, 50, 70, 170, 190, 290)
    )


@dataclass(slots=True)
class Ring:
    """A moving ring, a rigid body about its centre Ro.

    Half of each adjoining leg is lumped in; the articulated brace, whose legs
    have their own masses, takes these halves off again.
    """

    mass: float = number(0.85, "kg", above=0.0)
    inertia: np.ndarray = vector(
        0.0105, 0.0105, 0.0205, unit="kg m^2", above=0.0
    )
    # x and y, for drawing.
    half_axes: np.ndarray = vector(0.205, 0.205, unit="m", above=0.0)


@dataclass(slots=True)
class Leg:
    """A linear drive: its force is the command minus viscous times rate.

    A tube on the ring below, a rod on that above; both are taken as uniform
    cylinders as long as the closed leg.
    """

    viscous: float = number(40.0, "N s/m", least=0.0)
    force_limit: float = number(120.0, "N", above=0.0)  # of the command
    stroke: float = number(0.050, "m", above=0.0)  # centred on rest
    tube_mass: float = number(0.056, "kg", above=0.0)
    rod_mass: float = number(0.030, "kg", above=0.0)
    tube_radius: float = number(0.009, "m", above=0.0)
    rod_radius: float = number(0.004, "m", above=0.0)


@dataclass(slots=True)
class WorkspaceLimits:
    """What a pose of the brace has to keep to, beside the strokes.

    The smallest singular value of a stage's leg Jacobian, rotation scaled by
    the radius of its upper joints; 0 is a singularity.
    """

    singular_value: float = number(0.3, above=0.0)


@dataclass(slots=True)
class StartPoses:
    """Poses at time 0: displacement from rest, m, rotation vector, rad.

    A torso that starts nearer to a pad presses on it from the start.
    """

    ring1: np.ndarray = vector(0, 0, 0, 0, 0, 0)
    ring2: np.ndarray = vector(0, 0, 0, 0, 0, 0)
    ring3: np.ndarray = vector(0, 0, 0, 0, 0, 0)
    torso: np.ndarray = vector(0, 0, 0, 0, 0, 0)


@dataclass(slots=True)
class Torso:
    """A rigid body whose posture a bushing holds; To is at R2 at rest.

    `lean` is a constant force at To: the weight that a torso which no spring
    holds puts on the pads.
    """

    present: bool = True
    mass: float = number(40.0, "kg", above=0.0)
    inertia: np.ndarray = vector(1.05, 0.95, 0.42, unit="kg m^2", above=0.0)
    # Along the axes of W.
    posture_stiffness: np.ndarray = vector(
        2500, 1800, 20000, unit="N/m", least=0.0
    )
    posture_damping: np.ndarray = vector(250, 220, 600, unit="N s/m", least=0.0)
    posture_rot_stiffness: np.ndarray = vector(
        180, 180, 90, unit="N m/rad", least=0.0
    )
    posture_rot_damping: np.ndarray = vector(
        12, 12, 8, unit="N m s/rad", least=0.0
    )
    lean: np.ndarray = vector(0, 0, 0, unit="N", least=-100.0, most=100.0)


@dataclass(slots=True)
class Contact:
    """Pads of a ring against the torso.

    The linear law's numbers are always given; the hydroelastic ones are used
    where `model` says so. A rigid pad of area A that sinks by d into a layer of
    modulus E and thickness H meets N = (E A / H) d (1 + D d'), so that
    E = k H / A and, at a working depth d_0, D = c / (k d_0) give the linear k
    and c. Two pads that share a preload d_0 damp as the linear law does while
    both touch: their depths add up to 2 d_0.
    """

    model: str = word("linear", "none", "hydroelastic")
    stiffness: float = number(6400.0, "N/m", above=0.0)  # of one pad
    damping: float = number(150.0, "N s/m", least=0.0)
    friction: float = number(0.35, least=0.0)
    friction_regularization: float = number(0.005, "m/s", above=0.0)
    pad_offset: float = number(0.15, "m", above=0.0)  # of the face, along y
    preload: float = number(0.001, "m", least=0.0)  # of each pad at rest
    pad_size: np.ndarray = vector(0.060, 0.020, 0.080, unit="m", above=0.0)
    # On a torso's mesh, hydroelastic: points of a pad, across and up, that
    # stand for its face, see brace_drake.torso.faces; 0, 0: the whole face.
    pad_points: list[int] = items(2, 4)
    # These give the stiffness and damping above at the preload.
    hydroelastic_modulus: float = number(26666.666666666668, "Pa", above=0.0)
    hydroelastic_thickness: float = number(0.02, "m", above=0.0)
    hydroelastic_dissipation: float = number(23.4375, "s/m", least=0.0)


@dataclass(slots=True)
class RingContacts:
    """Pads of each moving ring."""

    ring1: Contact = field(default_factory=Contact)
    ring2: Contact = field(default_factory=Contact)
    ring3: Contact = field(default_factory=Contact)

    def __iter__(self):
        yield from (self.ring1, self.ring2, self.ring3)


@dataclass(slots=True)
class Sensors:
    """Instruments: standard deviations of noise, and resolutions."""

    leg_length_noise: float = number(5.0e-6, "m", least=0.0)
    leg_length_resolution: float = number(1.0e-5, "m", least=0.0)
    force_noise: float = number(0.03, "N", least=0.0)
    force_resolution: float = number(0.0244140625, "N", least=0.0)
    marker_noise: float = number(5.0e-5, "m", least=0.0)
    log_period: float = number(0.005, "s", above=0.0)


@dataclass(slots=True)
class EffectUse:
    """An effect that the twin carries, with the values of its parameters.

    `form` tells apart several laws of one effect; empty for the first.
    """

    name: str = ""
    parameters: dict[str, float] = field(default_factory=dict)
    form: str = ""


@dataclass(slots=True)
class BraceScenario:
    """Stacked stages with torso, contact, drives and instruments.

    The torso's bushing is at rest at ring 2. Effects are always on.
    """

    device: str = BRACE
    mechanism: str = word("task_space", "articulated")
    stages: list[int] = items(1, 2, 3)  # those that move, neighbours
    time_step: float = number(0.0005, "s", above=0.0)  # of the plant
    gravity: float = number(9.81, "m/s^2", least=0.0)
    # z in W, the clamped ring's first.
    ring_heights: np.ndarray = vector(0.0, 0.145, 0.235, 0.295, unit="m")
    joints: BraceJoints = field(default_factory=BraceJoints)
    ring: Ring = field(default_factory=Ring)
    leg: Leg = field(default_factory=Leg)
    workspace: WorkspaceLimits = field(default_factory=WorkspaceLimits)
    start: StartPoses = field(default_factory=StartPoses)
    torso: Torso = field(default_factory=Torso)
    contact: RingContacts = field(default_factory=RingContacts)
    control: BraceControl = field(default_factory=BraceControl)
    sensors: Sensors = field(default_factory=Sensors)
    tolerances: Tolerances = field(default_factory=Tolerances)
    effects: list[EffectUse] = items()

    @property
    def rings(self) -> tuple[str, ...]:
        """Names of the moving rings, bottom to top."""
        return tuple(f"ring{i}" for i in self.stages)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Of each moving ring, bottom to top."""
        return tuple(getattr(self.contact, name) for name in self.rings)

    def own_effects(self) -> dict[str, Effect]:
        """Cards of the effects that it can have, by key."""
        return stage_cards(self.device, self.stages)


@dataclass(slots=True)
class BenchScenario(BraceScenario):
    """The paper's bench: stage 2 of the brace alone, ring 1 clamped."""

    device: str = BENCH
    stages: list[int] = items(2)
    time_step: float = number(0.0002, "s", above=0.0)

"""The bench's scenario: every number of the twin, with unit and meaning."""

from dataclasses import dataclass, field

import numpy as np

DEVICE = "bench stage 2"


def _vector(*values: float):
    return field(default_factory=lambda: np.array(values, dtype=float))


@dataclass
class JointCircle:
    """Anchors on a circle of the ring: angles from x towards y."""

    radius: float = 0.19  # m
    angles_deg: np.ndarray = _vector(-13, 13, 107, 133, 227, 253)


@dataclass
class Stage:
    """The stage's geometry; leg k joins lower angle k to upper angle k."""

    lower_height: float = 0.145  # m, z of the clamped ring in W
    upper_height: float = 0.235  # m, z of the moving ring in W at rest
    lower: JointCircle = field(default_factory=JointCircle)
    upper: JointCircle = field(
        default_factory=lambda: JointCircle(
            0.18, np.array([-47.0, 47, 73, 167, 193, 287])
        )
    )


@dataclass
class Ring:
    """The moving ring, a rigid body about its centre Ro."""

    mass: float = 0.85  # kg
    inertia: np.ndarray = _vector(0.0105, 0.0105, 0.0205)  # kg m^2


@dataclass
class Leg:
    """A linear drive: its force is the command minus viscous times rate."""

    viscous: float = 40.0  # N s/m
    force_limit: float = 120.0  # N, of the command


@dataclass
class Torso:
    """A rigid body whose posture a bushing holds; To is at Ro at rest."""

    present: bool = True
    mass: float = 40.0  # kg
    inertia: np.ndarray = _vector(1.05, 0.95, 0.42)  # kg m^2 about To
    posture_stiffness: np.ndarray = _vector(2500, 1800, 20000)  # N/m, W axes
    posture_damping: np.ndarray = _vector(250, 220, 600)  # N s/m
    posture_rot_stiffness: np.ndarray = _vector(180, 180, 90)  # N m/rad
    posture_rot_damping: np.ndarray = _vector(12, 12, 8)  # N m s/rad


@dataclass
class Contact:
    """Pads against torso: `linear` or `hydroelastic`, one law or the other.

    The linear law's numbers are always given; the hydroelastic ones are used
    where `model` says so. A rigid pad of area A that sinks by d into a layer of
    modulus E and thickness H meets N = (E A / H) d (1 + D d'), so that
    E = k H / A and, at a working depth d_0, D = c / (k d_0) give the linear k
    and c. Two pads that share a preload d_0 damp as the linear law does while
    both touch: their depths add up to 2 d_0.
    """

    model: str = "linear"
    stiffness: float = 6400.0  # N/m of one pad
    damping: float = 150.0  # N s/m
    friction: float = 0.35
    friction_regularization: float = 0.005  # m/s
    pad_offset: float = 0.15  # m, of the pad's face from Ro along y
    preload: float = 0.001  # m, compression of each pad at rest
    pad_size: np.ndarray = _vector(0.060, 0.020, 0.080)  # m
    # On a torso's mesh, hydroelastic: points of a pad, across and up, that
    # stand for its face, see brace_drake.torso.faces; 0, 0: the whole face.
    pad_points: list[int] = field(default_factory=lambda: [2, 4])
    # These give the stiffness and damping above at the preload.
    hydroelastic_modulus: float = 26666.666666666668  # Pa, k H / A
    hydroelastic_thickness: float = 0.02  # m, H of the compliant layer
    hydroelastic_dissipation: float = 23.4375  # s/m, c / (k preload)


@dataclass
class Control:
    """Position-based impedance control on inverse dynamics."""

    rate: float = 1000.0  # Hz
    kp: float = 1600.0  # 1/s^2
    kd: float = 80.0  # 1/s
    velocity_cutoff_hz: float = 40.0
    force_filter_tau: float = 0.02  # s
    desired_mass: float = 2.0  # kg
    desired_stiffness: float = 6000.0  # N/m
    desired_damping: float = 219.0890230020664  # N s/m


@dataclass
class Sensors:
    """Instruments: standard deviations of noise, and resolutions."""

    leg_length_noise: float = 5.0e-6  # m
    leg_length_resolution: float = 1.0e-5  # m
    force_noise: float = 0.03  # N
    force_resolution: float = 0.0244140625  # N
    marker_noise: float = 5.0e-5  # m
    log_period: float = 0.005  # s


@dataclass
class EffectUse:
    """An effect that the twin carries, with the values of its parameters.

    `form` tells apart several laws of one effect; empty for the first.
    """

    name: str = ""
    parameters: dict[str, float] = field(default_factory=dict)
    form: str = ""


@dataclass
class BenchScenario:
    """One stage of the brace on the bench, with torso and controller."""

    device: str = DEVICE
    time_step: float = 0.0002  # s, of the plant
    gravity: float = 9.81  # m/s^2
    stage: Stage = field(default_factory=Stage)
    ring: Ring = field(default_factory=Ring)
    leg: Leg = field(default_factory=Leg)
    torso: Torso = field(default_factory=Torso)
    contact: Contact = field(default_factory=Contact)
    control: Control = field(default_factory=Control)
    sensors: Sensors = field(default_factory=Sensors)
    effects: list[EffectUse] = field(default_factory=list)

"""A bench scenario as the number arrays that the laws take."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brace_drake.kinematics import (
    BraceGeometry,
    circle_points,
    holding_leg_forces,
)
from brace_drake.laws.control import low_pass_gain_cutoff, low_pass_gain_tau
from brace_drake.scenario.bench import (
    BenchScenario,
    Contact,
    JointCircle,
    Sensors,
    Torso,
)


@dataclass(frozen=True)
class BenchNumbers:
    """Arrays of the bench; the plant's may differ from the controller's.

    Attributes:
        rest: Position of Ro and To in W at rest (3,), m.
        p_WB, p_RT: Anchors of the plant (6, 3), m.
        p_WB_known, p_RT_known: Anchors as the controller knows them.
        viscous: Of each leg (6,), N s/m.
        contact: Stiffness, damping, friction, regularisation speed, pad
            offset, preload (6,).
        posture: K (3), D (3), K_r (3), D_r (3): (12,).
        ring, torso: Mass, moments (3), weight (5,).
        estimator: Rest position (3), period, velocity gain (5,).
        impedance: M_d, C_d, K_d, force gain, period (5,).
        inverse_dynamics: kp, kd, diagonal of M (6), weight, limit (10,).
        resolution: Of lengths, m, and forces, N (2,).
        noise_sigma: Of lengths (6), force (3), marker (3): (12,).
    """

    rest: np.ndarray
    p_WB: np.ndarray
    p_RT: np.ndarray
    p_WB_known: np.ndarray
    p_RT_known: np.ndarray
    viscous: np.ndarray
    contact: np.ndarray
    posture: np.ndarray
    ring: np.ndarray
    torso: np.ndarray
    estimator: np.ndarray
    impedance: np.ndarray
    inverse_dynamics: np.ndarray
    resolution: np.ndarray
    noise_sigma: np.ndarray

    @property
    def controller_law(self) -> np.ndarray:
        """The controller's numbers as one vector (56,)."""
        arrays = (
            self.estimator,
            self.impedance,
            self.inverse_dynamics,
            self.p_WB_known,
            self.p_RT_known,
        )
        return np.concatenate([np.ravel(a) for a in arrays])

    @property
    def holding_forces(self) -> np.ndarray:
        """Forces of the legs, where they are, that hold the ring (6,), N."""
        return _hold(self, self.p_WB, self.p_RT)

    def with_changes(self, **arrays: np.ndarray) -> BenchNumbers:
        """A copy with some arrays replaced."""
        return replace(self, **arrays)


def joint_points(circle: JointCircle, height: float) -> np.ndarray:
    """Points of a joint circle at a height (6, 3), m."""
    return circle_points(circle.radius, circle.angles_deg, height)


def pack_contact(contact: Contact) -> np.ndarray:
    """Stiffness, damping, friction, its speed, pad offset, preload (6,)."""
    return np.array(
        [
            contact.stiffness,
            contact.damping,
            contact.friction,
            contact.friction_regularization,
            contact.pad_offset,
            contact.preload,
        ]
    )


def pack_posture(torso: Torso) -> np.ndarray:
    """The posture's K (3), D (3), K_r (3), D_r (3): (12,)."""
    return np.concatenate(
        [
            torso.posture_stiffness,
            torso.posture_damping,
            torso.posture_rot_stiffness,
            torso.posture_rot_damping,
        ]
    )


def pack_instruments(
    sensors: Sensors, num_stages: int
) -> dict[str, np.ndarray]:
    """`resolution` and `noise_sigma` of a brace's instruments."""
    noises = (
        sensors.leg_length_noise,
        sensors.force_noise,
        sensors.marker_noise,
    )
    return {
        "resolution": np.array(
            [sensors.leg_length_resolution, sensors.force_resolution]
        ),
        "noise_sigma": np.repeat(noises, [6 * num_stages, 3 * num_stages, 3]),
    }


def pack_bench(scenario: BenchScenario) -> BenchNumbers:
    """Arrays of the nominal twin that a scenario describes."""
    stage, ring, torso = scenario.stage, scenario.ring, scenario.torso
    control = scenario.control
    period = 1.0 / scenario.control.rate
    rest = np.array([0.0, 0.0, stage.upper_height])
    p_WB = joint_points(stage.lower, stage.lower_height)
    p_RT = joint_points(stage.upper, 0.0)
    weight = ring.mass * scenario.gravity
    velocity_gain = low_pass_gain_cutoff(control.velocity_cutoff_hz, period)
    return BenchNumbers(
        rest=rest,
        p_WB=p_WB,
        p_RT=p_RT,
        p_WB_known=p_WB,
        p_RT_known=p_RT,
        viscous=np.full(6, scenario.leg.viscous),
        contact=pack_contact(scenario.contact),
        posture=pack_posture(torso),
        ring=np.array([ring.mass, *ring.inertia, weight]),
        torso=np.array([torso.mass, *torso.inertia, 0.0]),
        estimator=np.array([*rest, period, velocity_gain]),
        impedance=np.array(
            [
                control.desired_mass,
                control.desired_damping,
                control.desired_stiffness,
                low_pass_gain_tau(control.force_filter_tau, period),
                period,
            ]
        ),
        inverse_dynamics=np.array(
            [
                control.kp,
                control.kd,
                *[ring.mass] * 3,
                *ring.inertia,
                weight,
                scenario.leg.force_limit,
            ]
        ),
        **pack_instruments(scenario.sensors, 1),
    )


def hold_forces(numbers: BenchNumbers) -> tuple[float, ...]:
    """Leg forces that carry the ring's weight at rest (6,), N.

    As the controller knows the anchors.
    """
    return tuple(
        _hold(numbers, numbers.p_WB_known, numbers.p_RT_known).tolist()
    )


def _hold(numbers, p_WB: np.ndarray, p_RT: np.ndarray) -> np.ndarray:
    geometry = BraceGeometry(p_WB[None], p_RT[None], numbers.rest[None])
    return holding_leg_forces(geometry, [numbers.ring[4]])

"""A brace scenario as the geometry and the number arrays that laws take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.kinematics import BraceGeometry, Workspace, make_geometry
from brace_drake.scenario.brace import (
    BraceScenario,
    Contact,
    Sensors,
    Torso,
)
from brace_drake.scenario.control_numbers import BraceRings


@dataclass(frozen=True)
class BraceNumbers:
    """Arrays of a brace with S moving rings, bottom to top.

    Attributes:
        geometry: Anchors, and the rings at rest.
        workspace: Poses that it may take.
        start: Task coordinates at time 0 (6 S,).
        torso_rest: Position of To in W at rest (3,), m: that of R2.
        viscous: Of each leg (6 S,), N s/m.
        contact: Of each ring stiffness, damping, friction, regularisation
            speed, pad offset, preload (S, 6); a stiffness of 0 is no pad.
        posture: K (3), D (3), K_r (3), D_r (3): (12,).
        ring: Mass, moments (3), weight (5,), of each the same.
        resolution: Of lengths, m, and forces, N (2,).
        noise_sigma: Of lengths (6 S), forces (3 S), marker (3).
    """

    geometry: BraceGeometry
    workspace: Workspace
    start: np.ndarray
    torso_rest: np.ndarray
    viscous: np.ndarray
    contact: np.ndarray
    posture: np.ndarray
    ring: np.ndarray
    resolution: np.ndarray
    noise_sigma: np.ndarray

    @property
    def num_stages(self) -> int:
        return self.geometry.num_stages

    @property
    def force_law(self) -> np.ndarray:
        """The law of the brace's forces, see `laws.kernels.num_law`."""
        arrays = (
            self.torso_rest,
            self.viscous,
            self.geometry.lower,
            self.geometry.upper,
            self.contact,
            self.posture,
        )
        return np.concatenate([np.ravel(a) for a in arrays])


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


def pack_geometry(scenario: BraceScenario) -> BraceGeometry:
    """Geometry of the stages that a scenario picks.

    Raises:
        KinematicsError: Legs without length, or a stage singular at rest.
    """
    joints = [getattr(scenario.joints, f"stage{i}") for i in scenario.stages]
    clamped = scenario.stages[0] - 1
    return make_geometry(
        [(j.lower.radius, j.lower.angles_deg) for j in joints],
        [(j.upper.radius, j.upper.angles_deg) for j in joints],
        scenario.ring_heights[clamped : clamped + len(joints) + 1],
    )


def pack_rings(scenario: BraceScenario) -> BraceRings:
    """What a controller knows of the rings and legs that a scenario picks."""
    ring, n = scenario.ring, len(scenario.stages)
    return BraceRings(
        geometry=pack_geometry(scenario),
        mass=np.tile([ring.mass, *ring.inertia], (n, 1)),
        force_limit=np.full(6 * n, scenario.leg.force_limit),
        gravity=scenario.gravity,
        start=_pack_start(scenario),
    )


def _pack_start(scenario: BraceScenario) -> np.ndarray:
    """Task coordinates at time 0 (6 S,)."""
    return np.concatenate([getattr(scenario.start, r) for r in scenario.rings])


def pack_brace(scenario: BraceScenario) -> BraceNumbers:
    """Arrays of the brace that a checked scenario describes."""
    ring, leg = scenario.ring, scenario.leg
    contact = np.array([pack_contact(c) for c in scenario.contacts])
    linear = np.array([c.model == "linear" for c in scenario.contacts])
    contact[~linear, 0:2] = 0.0
    return BraceNumbers(
        geometry=pack_geometry(scenario),
        workspace=Workspace(leg.stroke, scenario.workspace.singular_value),
        start=_pack_start(scenario),
        torso_rest=np.array([0.0, 0.0, scenario.ring_heights[2]]),
        viscous=np.full(6 * len(scenario.stages), leg.viscous),
        contact=contact,
        posture=pack_posture(scenario.torso),
        ring=np.array([ring.mass, *ring.inertia, ring.mass * scenario.gravity]),
        **pack_instruments(scenario.sensors, len(scenario.stages)),
    )

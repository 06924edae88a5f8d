"""A brace scenario as the number arrays that laws take."""

from __future__ import annotations

import numpy as np

from brace_drake.kinematics import BraceGeometry, Workspace, make_geometry
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.scenario.brace import (
    BraceScenario,
    Contact,
    Sensors,
    Torso,
)
from brace_drake.scenario.control_numbers import BraceRings, pack_control


def geometry_of(numbers: BraceNumbers) -> BraceGeometry:
    """Geometry of the stages, as the plant has it."""
    return BraceGeometry(numbers.lower, numbers.upper, numbers.rest)


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
    """The posture's K (3), D (3), K_r (3), D_r (3), lean (3): (15,)."""
    return np.concatenate(
        [
            torso.posture_stiffness,
            torso.posture_damping,
            torso.posture_rot_stiffness,
            torso.posture_rot_damping,
            torso.lean,
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


def pack_workspace(scenario: BraceScenario) -> Workspace:
    """Poses that the stages may take."""
    return Workspace(scenario.leg.stroke, scenario.workspace.singular_value)


def pack_rings(scenario: BraceScenario) -> BraceRings:
    """What a controller knows of the rings and legs that a scenario picks."""
    ring, n = scenario.ring, len(scenario.stages)
    return BraceRings(
        geometry=pack_geometry(scenario),
        mass=np.tile([ring.mass, *ring.inertia], (n, 1)),
        force_limit=np.full(6 * n, scenario.leg.force_limit),
        gravity=scenario.gravity,
        start=pack_start(scenario),
    )


def pack_start(scenario: BraceScenario) -> np.ndarray:
    """Task coordinates at time 0 (6 S,)."""
    return np.concatenate([getattr(scenario.start, r) for r in scenario.rings])


def pack_brace(scenario: BraceScenario) -> BraceNumbers:
    """Arrays of the brace that a checked scenario describes."""
    ring, torso, n = scenario.ring, scenario.torso, len(scenario.stages)
    contact = np.array([pack_contact(c) for c in scenario.contacts])
    linear = np.array([c.model == "linear" for c in scenario.contacts])
    # Else it is the plant that resolves the contact.
    contact[~linear, 0:2] = 0.0
    rings = pack_rings(scenario)
    weight = ring.mass * scenario.gravity
    return BraceNumbers(
        rest=np.ascontiguousarray(rings.geometry.rest),
        lower=np.ascontiguousarray(rings.geometry.lower),
        upper=np.ascontiguousarray(rings.geometry.upper),
        viscous=np.full(6 * n, scenario.leg.viscous),
        contact=contact,
        posture=pack_posture(torso),
        ring=np.tile([ring.mass, *ring.inertia, weight], (n, 1)),
        torso=np.array([torso.mass, *torso.inertia, 0.0]),
        torso_rest=np.array([0.0, 0.0, scenario.ring_heights[2]]),
        start=rings.start,
        torso_start=scenario.start.torso.copy(),
        control=pack_control(scenario.control, rings).law,
        **pack_instruments(scenario.sensors, n),
    )


def pack_bench(scenario: BraceScenario) -> BraceNumbers:
    """Arrays of the nominal compiled twin that a scenario describes.

    It knows the linear law of contact alone, whatever the model.

    Raises:
        KinematicsError: Legs without length, or a stage singular at rest.
    """
    contact = np.array([pack_contact(c) for c in scenario.contacts])
    return pack_brace(scenario).with_changes(contact=contact)

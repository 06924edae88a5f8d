"""Inertia of the articulated brace's links, from a scenario's numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.kinematics import BraceGeometry
from brace_drake.scenario.brace import BraceScenario


@dataclass(frozen=True)
class Link:
    """A rigid body.

    Attributes:
        mass: kg.
        p_LoLcm: Its centre of mass in its frame L (3,), m.
        I_LLcm: Its inertia about there, in L (3, 3), kg m^2.
    """

    mass: float
    p_LoLcm: np.ndarray
    I_LLcm: np.ndarray


def make_tube(scenario: BraceScenario, closed_length: float) -> Link:
    """The tube: a cylinder along z from its lower end, the frame's origin."""
    leg = scenario.leg
    return _cylinder(leg.tube_mass, leg.tube_radius, closed_length, 0.5)


def make_rod(scenario: BraceScenario, closed_length: float) -> Link:
    """The rod: a cylinder along z to its upper end, the frame's origin."""
    leg = scenario.leg
    return _cylinder(leg.rod_mass, leg.rod_radius, closed_length, -0.5)


def make_bare_ring(
    scenario: BraceScenario, geometry: BraceGeometry, i: int
) -> Link:
    """Ring i of the geometry without the halves of its legs.

    A scenario's ring has half of each adjoining leg lumped in, taken as a
    point at the leg's joint on the ring. Parallel axes take it off again.

    Raises:
        ScenarioError: Nothing that could be a body would be left.
    """
    ring, leg = scenario.ring, scenario.leg
    joints = geometry.upper[i]
    if i + 1 < geometry.num_stages:
        joints = np.vstack([joints, geometry.lower[i + 1]])
    half = 0.5 * (leg.tube_mass + leg.rod_mass)
    mass = ring.mass - half * len(joints)
    inertia = np.diag(ring.inertia) - half * _second_moment(joints)
    p_RRcm = -half * joints.sum(axis=0) / mass if mass > 0.0 else np.zeros(3)
    inertia -= mass * _second_moment(p_RRcm[np.newaxis])
    principal = np.linalg.eigvalsh(inertia)
    if (
        mass <= 0.0
        or principal[0] <= 0.0
        or (principal[2] > principal[0] + principal[1])
    ):
        raise ScenarioError(
            f"ring.mass is {ring.mass}, ring.inertia {ring.inertia.tolist()};"
            f" allowed: what leaves a body without half of its {len(joints)}"
            f" legs of {2 * half:.4g} kg; left are {mass:.4g} kg and"
            f" {np.round(principal, 6).tolist()} kg m^2"
        )
    return Link(mass, p_RRcm, inertia)


def _cylinder(mass: float, radius: float, length: float, at: float) -> Link:
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    along = 0.5 * mass * radius**2
    p_LoLcm = np.array([0.0, 0.0, at * length])
    return Link(mass, p_LoLcm, np.diag([across, across, along]))


def _second_moment(points: np.ndarray) -> np.ndarray:
    """Inertia (3, 3) about the origin of points (n, 3) of 1 kg each."""
    return (points**2).sum() * np.eye(3) - points.T @ points

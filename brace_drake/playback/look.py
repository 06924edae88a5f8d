"""Sizes of what is drawn, from a scenario's numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.kinematics import BraceGeometry
from brace_drake.scenario.brace import (
    BraceScenario,
    Contact,
    Leg,
)
from brace_drake.scenario.brace_numbers import pack_geometry
from brace_drake.scenario.load import Scenario


@dataclass(frozen=True)
class Look:
    """Sizes of a brace of S stages, m.

    Attributes:
        geometry: Anchors of the legs.
        rings: Names of the moving rings, bottom to top.
        clamped_height: z of the clamped ring in W.
        half_axes: Of the rings' outer edge, x and y (2,).
        leg: Radii, and the stroke, which sets how long tube and rod are.
        contacts: Pads of each moving ring; None: it has none.
        torso_rest: z of the torso's origin in W at rest.
    """

    geometry: BraceGeometry
    rings: tuple[str, ...]
    clamped_height: float
    half_axes: np.ndarray
    leg: Leg
    contacts: tuple[Contact | None, ...]
    torso_rest: float


def make_look(scenario: Scenario) -> Look:
    """Sizes for bench or brace.

    Raises:
        ScenarioError: The device has no rings.
    """
    if isinstance(scenario, BraceScenario):
        return Look(
            pack_geometry(scenario),
            scenario.rings,
            float(scenario.ring_heights[scenario.stages[0] - 1]),
            scenario.ring.half_axes,
            scenario.leg,
            tuple(
                contact
                if scenario.torso.present and contact.model != "none"
                else None
                for contact in scenario.contacts
            ),
            float(scenario.ring_heights[2]),
        )
    raise ScenarioError(
        f"device is {scenario.device!r}; allowed for a playback in 3D: bench"
        " or brace"
    )

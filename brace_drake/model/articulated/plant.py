"""Rings and legs of the articulated brace in a plant, with closed loops."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, RigidBody
from pydrake.systems.framework import Context

from brace_drake.model.articulated.models import (
    DIRECTIVES,
    PACKAGE,
    WriteBraceModels,
    calc_leg_frame,
    leg_name,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_geometry


def AddArticulatedBrace(plant: MultibodyPlant, scenario: BraceScenario) -> None:
    """Adds rings and 6 S driven legs to a discrete plant not yet final.

    Tube and rod of a leg hang on the ring below by a universal joint; the
    rod's end is held to the ring above by a ball constraint. Drives are
    actuators in the order of the legs, f > 0 pushes the rings apart; they are
    damped by `leg.viscous` and stop at the ends of their strokes.

    Raises:
        ScenarioError: A ring is too light for the halves of its legs.
    """
    with tempfile.TemporaryDirectory() as folder:
        WriteBraceModels(scenario, Path(folder))
        parser = Parser(plant)
        parser.package_map().Add(PACKAGE, folder)
        parser.AddModels(str(Path(folder) / DIRECTIVES))
    joints = pack_geometry(scenario).upper.reshape(-1, 3)
    closures = GetClosures(plant, scenario)
    for (rod, ring), p_RJ in zip(closures, joints, strict=True):
        plant.AddBallConstraint(rod, np.zeros(3), ring, p_RJ)


def GetClosures(
    plant: MultibodyPlant, scenario: BraceScenario
) -> list[tuple[RigidBody, RigidBody]]:
    """Rod and ring that a ball constraint joins, of all legs, bottom to top."""
    return [
        (_Part(plant, scenario, i, k, "rod"), plant.GetBodyByName(ring))
        for i, ring in enumerate(scenario.rings)
        for k in range(6)
    ]


def GetDrives(
    plant: MultibodyPlant, scenario: BraceScenario
) -> list[PrismaticJoint]:
    """The drives of all legs, bottom to top; positions are 0 at rest."""
    return [
        plant.GetJointByName(
            "drive",
            plant.GetModelInstanceByName(leg_name(scenario, i, k)),
        )
        for i in range(len(scenario.stages))
        for k in range(6)
    ]


def SetLegs(
    plant: MultibodyPlant,
    context: Context,
    scenario: BraceScenario,
    poses: Sequence[RigidTransform],
) -> None:
    """Sets the joints of all legs so that they reach rings at X_WR `poses`."""
    geometry, drives = pack_geometry(scenario), GetDrives(plant, scenario)
    for i, X_WR in enumerate(poses):
        X_WL = poses[i - 1] if i else RigidTransform()
        for k in range(6):
            X_LF = RigidTransform(
                RollPitchYaw(calc_leg_frame(geometry, i, k)),
                geometry.lower[i, k],
            )
            tip = (X_WL @ X_LF).inverse() @ (X_WR @ geometry.upper[i, k])
            length = np.linalg.norm(tip)
            x, y, z = tip / length
            # The tube's z-axis is Rx(a) Ry(b) z.
            joint = plant.GetJointByName(
                "universal",
                plant.GetModelInstanceByName(leg_name(scenario, i, k)),
            )
            joint.set_angles(context, [np.arctan2(-y, z), np.arcsin(x)])
            drive, rest = drives[6 * i + k], geometry.rest_lengths[6 * i + k]
            drive.set_translation(context, length - rest)


def calc_closure_error(
    plant: MultibodyPlant, context: Context, scenario: BraceScenario
) -> float:
    """Largest distance of a rod's end from its joint on the ring, m."""
    geometry, errors = pack_geometry(scenario), []
    for i, ring in enumerate(scenario.rings):
        X_WR = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(ring))
        for k in range(6):
            rod = _Part(plant, scenario, i, k, "rod")
            end = plant.EvalBodyPoseInWorld(context, rod).translation()
            errors.append(np.linalg.norm(X_WR @ geometry.upper[i, k] - end))
    return max(errors)


def _Part(plant, scenario, i, k, part):
    instance = plant.GetModelInstanceByName(leg_name(scenario, i, k))
    return plant.GetBodyByName(part, instance)

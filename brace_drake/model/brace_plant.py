"""The brace's bodies as a Drake plant: rings and torso, or all 18 legs too."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder

from brace_drake.core.resources import sdf_path
from brace_drake.model.articulated import AddArticulatedBrace, SetLegs
from brace_drake.model.hydroelastic_pads import AddHalfSpacePads
from brace_drake.scenario.brace import BraceScenario, Ring, Torso
from brace_drake.scenario.brace_numbers import pack_brace, pack_geometry

# Adds geometry to bodies (`ring1` ... `ring3`, `torso`) of a plant that is
# registered with the scene graph and not yet final.
AddGeometry = Callable[[MultibodyPlant, SceneGraph, BraceScenario], None]


def plant_resolves_contact(scenario: BraceScenario) -> bool:
    """Whether a ring meets the torso in the plant, not in a computed force."""
    models = [contact.model for contact in scenario.contacts]
    return scenario.torso.present and "hydroelastic" in models


def AddBracePlant(
    builder: DiagramBuilder,
    scenario: BraceScenario,
    add_geometry: AddGeometry | None = None,
) -> MultibodyPlant:
    """Adds the finalized plant of rings and, where present, torso.

    All of them float (the paper's six-degree-of-freedom joint); they start at
    the scenario's poses. Gravity acts on rings and legs: the pelvis carries the
    torso. `task_space` has no further bodies, and q holds the rings from
    the lowest up, then the torso; `articulated` has 18 legs of tube and rod,
    see `brace_drake.model.articulated`.

    Args:
        builder: Of the diagram.
        scenario: Of the brace.
        add_geometry: Adds geometry to rings and torso, and may set how the
            plant resolves contact; without it, where a ring's contact is
            hydroelastic, its pads meet half spaces.
    """
    plant = builder.AddNamedSystem("plant", MultibodyPlant(scenario.time_step))
    if add_geometry is None and plant_resolves_contact(scenario):
        add_geometry = AddHydroelasticPads
    # Bodies are drawn where there is a scene graph already.
    scene_graph = add_geometry and AddSceneGraphFor(builder, plant)
    AddBraceBodies(plant, scenario)
    # Sampled ports would make the plant's step an unrestricted update, whose
    # copies of all state cost more than the step.
    plant.SetUseSampledOutputPorts(False)
    plant.set_discrete_contact_approximation(_approximation(scenario))
    if add_geometry is not None:
        add_geometry(plant, scene_graph, scenario)
    plant.Finalize()
    _SetStart(plant, scenario)
    return plant


def _approximation(scenario: BraceScenario) -> DiscreteContactApproximation:
    """What solves for contacts and constraints at a step."""
    if plant_resolves_contact(scenario):
        # Takes Hunt-Crossley dissipation and the stiction tolerance.
        return DiscreteContactApproximation.kLagged
    if scenario.mechanism == "articulated":
        return DiscreteContactApproximation.kSap
    # Nothing is left to the solver: take the cheapest.
    return DiscreteContactApproximation.kTamsi


def AddBraceBodies(plant: MultibodyPlant, scenario: BraceScenario) -> None:
    """Adds rings, legs and torso to a plant not yet final."""
    plant.mutable_gravity_field().set_gravity_vector(
        [0.0, 0.0, -scenario.gravity]
    )
    if scenario.mechanism == "articulated":
        AddArticulatedBrace(plant, scenario)
    else:
        for name in scenario.rings:
            AddBody(plant, name, scenario.ring)
    if scenario.torso.present:
        torso = AddBody(plant, "torso", scenario.torso)
        plant.set_gravity_enabled(torso.model_instance(), False)


def AddBody(
    plant: MultibodyPlant, name: str, config: Ring | Torso
) -> RigidBody:
    """Adds the body of `sdf/{name}.sdf` with a scenario's mass and moments."""
    text = _model_with_inertia(name, config.mass, config.inertia)
    (instance,) = Parser(plant).AddModelsFromString(text, "sdf")
    return plant.GetBodyByName(name, instance)


def _model_with_inertia(name: str, mass: float, moments: np.ndarray) -> str:
    """The SDF text of `sdf/{name}.sdf` with a scenario's mass and moments."""
    root = ElementTree.parse(sdf_path(f"{name}.sdf")).getroot()
    values = {"mass": mass}
    values |= dict(zip(("ixx", "iyy", "izz"), moments, strict=True))
    for tag, value in values.items():
        root.find(f".//inertial//{tag}").text = repr(float(value))
    return ElementTree.tostring(root, encoding="unicode")


def AddSceneGraphFor(
    builder: DiagramBuilder, plant: MultibodyPlant
) -> SceneGraph:
    """Adds a scene graph, and the plant as its source."""
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    builder.Connect(
        scene_graph.get_query_output_port(),
        plant.get_geometry_query_input_port(),
    )
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    return scene_graph


def AddHydroelasticPads(
    plant: MultibodyPlant, scene_graph: SceneGraph, scenario: BraceScenario
) -> None:
    """Adds pads to the rings that ask for them, half spaces to the torso."""
    AddHalfSpacePads(
        plant,
        scene_graph,
        {
            name: contact
            for name, contact in zip(
                scenario.rings, scenario.contacts, strict=True
            )
            if contact.model == "hydroelastic"
        },
    )


def SetBracePose(
    plant: MultibodyPlant,
    context: Context,
    scenario: BraceScenario,
    X: np.ndarray,
) -> None:
    """Sets rings, and legs where they are bodies, at X (6 S,), loops closed.

    Args:
        plant: Of the brace.
        context: The plant's own.
        scenario: That the plant was made of.
        X: Task coordinates.
    """
    poses, rings = [], pack_geometry(scenario).rest
    for rest, x in zip(rings, np.reshape(X, (-1, 6)), strict=True):
        poses.append(_PoseOf(rest, x))
    for name, X_WR in zip(scenario.rings, poses, strict=True):
        plant.SetFreeBodyPose(context, plant.GetBodyByName(name), X_WR)
    if scenario.mechanism == "articulated":
        SetLegs(plant, context, scenario, poses)


def _PoseOf(rest: np.ndarray, x: np.ndarray) -> RigidTransform:
    """At a displacement from rest, m, turned by a rotation vector, rad."""
    angle = np.linalg.norm(x[3:6])
    axis = x[3:6] / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    return RigidTransform(RotationMatrix(AngleAxis(angle, axis)), rest + x[0:3])


def _SetStart(plant: MultibodyPlant, scenario: BraceScenario) -> None:
    context, numbers = plant.CreateDefaultContext(), pack_brace(scenario)
    SetBracePose(plant, context, scenario, numbers.start)
    if scenario.torso.present:
        X_WT = _PoseOf(numbers.torso_rest, numbers.torso_start)
        plant.SetFreeBodyPose(context, plant.GetBodyByName("torso"), X_WT)
    plant.SetDefaultPositions(plant.GetPositions(context))

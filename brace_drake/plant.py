"""The bench's bodies as a Drake plant."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    HalfSpace,
    InMemoryMesh,
    Mesh,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from brace_drake.resources import sdf_path
from brace_drake.scenario.bench import BenchScenario, Contact, Ring, Torso


def _model_with_inertia(name: str, mass: float, moments: np.ndarray) -> str:
    """The SDF text of `sdf/{name}.sdf` with a scenario's mass and moments."""
    root = ElementTree.parse(sdf_path(f"{name}.sdf")).getroot()
    values = {"mass": mass}
    values |= dict(zip(("ixx", "iyy", "izz"), moments, strict=True))
    for tag, value in values.items():
        root.find(f".//inertial//{tag}").text = repr(float(value))
    return ElementTree.tostring(root, encoding="unicode")


def AddBenchPlant(
    builder: DiagramBuilder, scenario: BenchScenario
) -> MultibodyPlant:
    """Adds the finalized plant of ring and, where present, torso.

    Both float freely (the paper's six-degree-of-freedom joint); q holds the
    ring first, then the torso. Gravity acts on the ring alone: the pelvis
    carries the torso. Legs, posture and linear contact are forces that other
    systems apply; hydroelastic contact is the plant's.
    """
    plant = builder.AddNamedSystem(
        "plant", MultibodyPlant(time_step=scenario.time_step)
    )
    AddBenchBodies(plant, scenario)
    # Sampled ports would make the plant's step an unrestricted update, whose
    # copies of all state cost more than the step.
    plant.SetUseSampledOutputPorts(False)
    if plant_resolves_contact(scenario):
        AddHydroelasticContact(builder, plant, scenario.contact)
    else:
        # Nothing is left to the contact solver: take the cheapest.
        plant.set_discrete_contact_approximation(
            DiscreteContactApproximation.kTamsi
        )
    plant.Finalize()
    return plant


def AddHydroelasticContact(
    builder: DiagramBuilder, plant: MultibodyPlant, contact: Contact
) -> None:
    """Adds two rigid pads on the ring and the torso's compliant sides.

    A side is a compliant half space through y = +-pad_offset of the torso: the
    pressure E d / H is then the same all over a pad's face and grows linearly
    with the depth d, so N = (E A / H) d (1 + D d'), while a compliant box has
    softer edges. Each pad's face lies `preload` inside. Only `lagged` and
    `similar` take Hunt-Crossley dissipation and the stiction tolerance.
    """
    scene_graph = AddSceneGraphFor(builder, plant)
    AddHalfSpacePads(plant, scene_graph, {"ring2": contact})


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


def AddHalfSpacePads(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    contacts: Mapping[str, Contact],
) -> None:
    """Adds the pads of rings by name, and a half space under each pad.

    The law is that of `AddHydroelasticContact`; the stiction tolerance is the
    smallest of the contacts'.
    """
    plant.set_contact_model(ContactModel.kHydroelastic)
    plant.set_discrete_contact_approximation(
        DiscreteContactApproximation.kLagged
    )
    plant.set_stiction_tolerance(
        min(c.friction_regularization for c in contacts.values())
    )
    pads, sides = zip(
        *(
            _AddPadAndSide(plant, ring, contact, s)
            for ring, contact in contacts.items()
            for s in (1.0, -1.0)
        ),
        strict=True,
    )
    # Pads of neighbours are as high as the rings are apart.
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(GeometrySet(pads))
    )
    # A half space reaches through the torso to all other pads.
    for i, pad in enumerate(pads):
        others = GeometrySet([*sides[:i], *sides[i + 1 :]])
        scene_graph.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeBetween(
                GeometrySet(pad), others
            )
        )


def _AddPadAndSide(
    plant: MultibodyPlant, ring: str, contact: Contact, s: float
) -> tuple[GeometryId, GeometryId]:
    """Adds the ring's pad at s y and the torso's side under it."""
    friction = CoulombFriction(contact.friction, contact.friction)
    rigid, compliant = ProximityProperties(), ProximityProperties()
    AddRigidHydroelasticProperties(rigid)
    AddCompliantHydroelasticPropertiesForHalfSpace(
        contact.hydroelastic_thickness,
        contact.hydroelastic_modulus,
        compliant,
    )
    AddContactMaterial(friction=friction, properties=rigid)
    AddContactMaterial(
        contact.hydroelastic_dissipation, None, friction, compliant
    )
    size, name = contact.pad_size, "left" if s > 0 else "right"
    face = contact.pad_offset - contact.preload
    pad = plant.RegisterCollisionGeometry(
        plant.GetBodyByName(ring),
        RigidTransform([0.0, s * face, 0.0]),
        _make_pad_face(size, s),
        f"{ring}_{name}_pad",
        rigid,
    )
    outward, surface = np.array([0.0, s, 0.0]), [0.0, s * contact.pad_offset, 0]
    side = plant.RegisterCollisionGeometry(
        plant.GetBodyByName("torso"),
        HalfSpace.MakePose(outward, surface),
        HalfSpace(),
        f"{ring}_{name}_side",
        compliant,
    )
    return pad, side


def _make_pad_face(size: np.ndarray, s: float) -> Mesh:
    """The pad's rectangle, facing the torso at -s y.

    Without the pad's sides: they stand square to the pressure gradient, and
    Drake's contact would drop and take them from step to step.
    """
    x, z = 0.5 * size[0], 0.5 * size[2]
    corners = [(-x, -z), (x, -z), (x, z), (-x, z)]
    lines = [f"v {a} 0 {b}" for a, b in corners]
    order = [(1, 2, 3), (1, 3, 4)] if s > 0 else [(1, 3, 2), (1, 4, 3)]
    lines += [f"f {a} {b} {c}" for a, b, c in order]
    text = "\n".join(lines)
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "pad face")))


def plant_resolves_contact(scenario: BenchScenario) -> bool:
    """Whether pads and torso meet in the plant, not in a computed force."""
    return scenario.torso.present and scenario.contact.model == "hydroelastic"


def AddBenchBodies(plant: MultibodyPlant, scenario: BenchScenario) -> None:
    """Adds ring and torso at their rest poses to a plant not yet final."""
    plant.mutable_gravity_field().set_gravity_vector(
        [0.0, 0.0, -scenario.gravity]
    )
    X_WRest = RigidTransform([0.0, 0.0, scenario.stage.upper_height])
    bodies = {"ring2": scenario.ring}
    if scenario.torso.present:
        bodies["torso"] = scenario.torso
    for name, config in bodies.items():
        body = AddBody(plant, name, config)
        plant.SetDefaultFloatingBaseBodyPose(body, X_WRest)
        if name == "torso":
            plant.set_gravity_enabled(body.model_instance(), False)


def AddStateLog(
    builder: DiagramBuilder, plant: MultibodyPlant, period: float
) -> VectorLogSink:
    """Adds a log of the plant's state, every `period`, s."""
    port = plant.get_state_output_port()
    sink = LogVectorOutput(port, builder, period)
    sink.set_name("state_log")
    return sink


def AddBody(
    plant: MultibodyPlant, name: str, config: Ring | Torso
) -> RigidBody:
    """Adds the body of `sdf/{name}.sdf` with a scenario's mass and moments."""
    text = _model_with_inertia(name, config.mass, config.inertia)
    (instance,) = Parser(plant).AddModelsFromString(text, "sdf")
    return plant.GetBodyByName(name, instance)

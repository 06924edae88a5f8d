"""Pads against the torso as Drake's hydroelastic contact.

The torso is a compliant solid, the pads are rigid faces. A pad that sinks by d
meets the pressure κ d (1 + D d'), with κ the foundation modulus, N/m^3, and D
the dissipation, s/m. The linear law's stiffness k of one pad and its damping c
at the working depth p map to

    κ = k / A_n,    D = c / (k p),

A_n the effective area of a pad (brace_drake.torso.pads), here its mean.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    InMemoryMesh,
    Mesh,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import RigidBody

from brace_drake.core.errors import TorsoError
from brace_drake.scenario.brace import BraceScenario, Contact
from brace_drake.torso.faces import SHARE, make_point_pad
from brace_drake.torso.fitted import FittedTorso
from brace_drake.torso.meshes import obj_text, vtk_text
from brace_drake.torso.pads import Pad
from brace_drake.torso.solid import Solid, surface_volume

# Drake's mesh may differ from ours by what the text of its file rounds.
_VOLUME = 1e-6


@dataclass(frozen=True)
class TorsoContact:
    """Numbers of the contact.

    Attributes:
        foundation_modulus: κ, pressure over depth, N/m^3.
        dissipation: D of Hunt and Crossley, s/m; `lagged` and `similar`.
        friction: Coulomb's coefficient, at rest and sliding.
        stiction_tolerance: Sliding speed from which friction is full, m/s;
            `lagged` and `similar`.
        relaxation_time: c / k, s; `sap`.
        preload: Depth of each pad at rest, m.
        points: Of a pad, across and up, see `points`; 0, 0: its whole face.
        approximation: Of Drake's discrete contact.
    """

    foundation_modulus: float
    dissipation: float = 0.0
    friction: float = 0.0
    stiction_tolerance: float = 0.005
    relaxation_time: float = 0.0
    preload: float = 0.0
    points: tuple[int, int] = (0, 0)
    approximation: DiscreteContactApproximation = (
        DiscreteContactApproximation.kLagged
    )


def map_linear_contact(contact: Contact, effective_area: float) -> TorsoContact:
    """Numbers that give a scenario's linear stiffness and damping.

    The damping is that of the linear law at the preload, where there is one.

    Args:
        contact: Of the scenario.
        effective_area: A_n, the mean of the pads, m^2.
    """
    relaxation = contact.damping / contact.stiffness
    return TorsoContact(
        foundation_modulus=contact.stiffness / effective_area,
        dissipation=relaxation / contact.preload if contact.preload else 0.0,
        friction=contact.friction,
        stiction_tolerance=contact.friction_regularization,
        relaxation_time=relaxation,
        preload=contact.preload,
        points=tuple(int(n) for n in contact.pad_points),
    )


def AddTorsoContact(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    torso_body: RigidBody,
    ring_bodies: Mapping[int, RigidBody],
    torso: FittedTorso,
    contact: TorsoContact,
) -> dict[str, GeometryId]:
    """Adds the torso's solid and the pads of some rings to a plant.

    Call it before Finalize, with the plant registered at the scene graph. It
    chooses the plant's contact model, hydroelastic, and its approximation.

    Args:
        torso_body: Its frame is T.
        ring_bodies: By number, 1 for the lowest moving ring; their frames are
            at the rings' centres, aligned with T at rest. Pads of rings that
            are not given are left out.

    Returns:
        Geometries by name: "torso", "ring1_left", "ring1_right" and so on.

    Raises:
        TorsoError: A ring has no pads, or Drake's solid is not ours.
    """
    plant.set_contact_model(ContactModel.kHydroelastic)
    plant.set_discrete_contact_approximation(contact.approximation)
    plant.set_stiction_tolerance(contact.stiction_tolerance)
    rings = {pad.place.ring for pad in torso.pads}
    for ring in ring_bodies:
        if ring not in rings:
            known = ", ".join(str(r) for r in sorted(rings))
            raise TorsoError(f"ring {ring} has no pads; allowed: {known}")
    modulus = contact.foundation_modulus * torso.deepest
    in_points = min(contact.points) > 0
    if in_points:
        modulus /= SHARE
    found = {
        "torso": AddCompliantSolid(
            plant, scene_graph, torso_body, torso.solid, modulus, contact
        )
    }
    for pad in torso.pads:
        if pad.place.ring not in ring_bodies:
            continue
        body = ring_bodies[pad.place.ring]
        p_TR = [0.0, 0.0, torso.ring_heights[pad.place.ring - 1]]
        face = make_point_pad(pad, *contact.points) if in_points else pad
        found[pad.place.name] = AddRigidPad(plant, body, face, p_TR, contact)
    # Pads of neighbouring rings may be as high as the rings are apart.
    pads = GeometrySet([g for n, g in found.items() if n != "torso"])
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(pads)
    )
    return found


def MakeTorsoGeometry(
    torso: FittedTorso,
) -> Callable[[MultibodyPlant, SceneGraph, BraceScenario], None]:
    """The contact of a torso as a function for a brace's `add_geometry`.

    Rings whose contact in the scenario is hydroelastic get their pads. The
    torso has one foundation modulus: that of the rings' mean stiffness; the
    other numbers are those of the lowest.
    """

    def add_geometry(plant, scene_graph, scenario) -> None:
        named = zip(scenario.rings, scenario.contacts, strict=True)
        own = {n: c for n, c in named if c.model == "hydroelastic"}
        if not own:
            return
        mean = float(np.mean([c.stiffness for c in own.values()]))
        first = replace(next(iter(own.values())), stiffness=mean)
        bodies = {
            int(name.removeprefix("ring")): plant.GetBodyByName(name)
            for name in own
        }
        AddTorsoContact(
            plant,
            scene_graph,
            plant.GetBodyByName("torso"),
            bodies,
            torso,
            map_linear_contact(first, torso.mean_effective_area),
        )

    return add_geometry


def AddCompliantSolid(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    body: RigidBody,
    solid: Solid,
    modulus: float,
    contact: TorsoContact,
) -> GeometryId:
    """Adds a solid to a body as a compliant mesh.

    Args:
        modulus: Drake's hydroelastic modulus: the pressure at the deepest
            node, Pa.

    Raises:
        TorsoError: Drake's solid is not ours.
    """
    properties = ProximityProperties()
    AddCompliantHydroelasticProperties(1.0, modulus, properties)
    AddContactMaterial(
        contact.dissipation,
        None,
        CoulombFriction(contact.friction, contact.friction),
        properties,
    )
    properties.AddProperty(
        "material", "relaxation_time", contact.relaxation_time
    )
    geometry = plant.RegisterCollisionGeometry(
        body,
        RigidTransform(),
        _mesh(vtk_text(solid), ".vtk", "torso"),
        "torso",
        properties,
    )
    check_volume(scene_graph, geometry, solid)
    return geometry


def check_volume(
    scene_graph: SceneGraph, geometry: GeometryId, solid: Solid
) -> None:
    """Refuses a mesh that Drake took for another shape.

    A mesh without tetrahedra that should be compliant becomes its convex hull
    without a word.

    Raises:
        TorsoError: It names both volumes.
    """
    inspector = scene_graph.model_inspector()
    mesh = inspector.maybe_get_hydroelastic_mesh(geometry)
    ours = surface_volume(solid.vertices, solid.triangles)
    drake = mesh.CalcVolume() if hasattr(mesh, "CalcVolume") else 0.0
    if abs(drake - ours) > _VOLUME * ours:
        raise TorsoError(
            f"Drake holds {drake:.6g} m^3 of the torso; allowed: {ours:.6g},"
            " the solid's own"
        )


def AddRigidPad(
    plant: MultibodyPlant, body: RigidBody, pad: Pad, p_TR, contact
) -> GeometryId:
    """Adds a pad's face to its ring, `preload` inside the torso at rest.

    Args:
        p_TR: The ring's centre in T at rest (3,), m.
    """
    properties = ProximityProperties()
    AddRigidHydroelasticProperties(properties)
    AddContactMaterial(
        friction=CoulombFriction(contact.friction, contact.friction),
        properties=properties,
    )
    # A face without sides: Drake's contact would drop and take those, square
    # to the pressure's gradient, from step to step.
    vertices = pad.vertices - np.asarray(p_TR)
    vertices = vertices - contact.preload * pad.place.normal
    return plant.RegisterCollisionGeometry(
        body,
        RigidTransform(),
        _mesh(obj_text(vertices, pad.triangles), ".obj", pad.place.name),
        f"{pad.place.name}_pad",
        properties,
    )


def _mesh(text: str, extension: str, name: str) -> Mesh:
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, extension, name)))

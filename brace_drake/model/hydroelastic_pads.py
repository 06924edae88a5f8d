"""Pads as Drake's hydroelastic contact has them."""

from __future__ import annotations

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
from pydrake.multibody.plant import (
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)

from brace_drake.scenario.brace import Contact


def AddHalfSpacePads(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    contacts: Mapping[str, Contact],
) -> None:
    """Adds the pads of rings by name, and a half space under each pad.

    A side is a compliant half space through y = +-pad_offset of the torso: the
    pressure E d / H is then the same all over a pad's face and grows linearly
    with the depth d, so N = (E A / H) d (1 + D d'), while a compliant box has
    softer edges. Each pad's face lies `preload` inside. Only `lagged` and
    `similar` take Hunt-Crossley dissipation and the stiction tolerance, the
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

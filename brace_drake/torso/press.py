"""Presses the pads of a torso into it in Drake and reads their forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.framework import Diagram, DiagramBuilder

from brace_drake.torso.contact import AddTorsoContact
from brace_drake.torso.contact_numbers import TorsoContact
from brace_drake.torso.fitted import FittedTorso

# A press that contact does not move, kg, within a step of 10 us: then the
# force is that at the given pose.
_IMMOVABLE = 1e6
_STEP = 1e-5
_BALL = UnitInertia.SolidSphere(0.1)


def MakeRingsAndTorso(
    torso: FittedTorso,
    contact: TorsoContact,
    time_step: float,
    ring_mass: float = _IMMOVABLE,
    torso_mass: float = _IMMOVABLE,
) -> tuple[Diagram, MultibodyPlant, dict]:
    """A plant of free rings around a free torso, without gravity.

    Returns:
        Diagram, plant and geometries by name. Bodies are "torso" (frame T, at
        W) and "ring1", "ring2", ...
    """
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    body = plant.AddRigidBody("torso", _inertia(torso_mass))
    rings = {}
    for i, height in enumerate(torso.ring_heights, start=1):
        rings[i] = plant.AddRigidBody(f"ring{i}", _inertia(ring_mass))
        plant.SetDefaultFloatingBaseBodyPose(
            rings[i], RigidTransform([0.0, 0.0, height])
        )
    geometries = AddTorsoContact(
        plant, scene_graph, body, rings, torso, contact
    )
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    return builder.Build(), plant, geometries


def _inertia(mass: float) -> SpatialInertia:
    return SpatialInertia(mass, [0.0, 0.0, 0.0], _BALL)


def press_pads(
    torso: FittedTorso,
    contact: TorsoContact,
    motions: Sequence[RigidTransform],
) -> np.ndarray:
    """Forces of the pads on the torso with every ring moved from its rest.

    Args:
        motions: Pose of each ring in its frame at rest, the same for all.

    Returns:
        In T, in the order of `torso.pads` (motions, pads, 3), N.
    """
    diagram, plant, geometries = MakeRingsAndTorso(torso, contact, _STEP)
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    names = {geometry: name for name, geometry in geometries.items()}
    order = [pad.place.name for pad in torso.pads]
    forces = np.zeros((len(motions), len(order), 3))
    for force, motion in zip(forces, motions, strict=True):
        for i, height in enumerate(torso.ring_heights, start=1):
            rest = RigidTransform([0.0, 0.0, height])
            ring = plant.GetBodyByName(f"ring{i}")
            plant.SetFloatingBaseBodyPoseInWorldFrame(own, ring, rest @ motion)
        for name, F_T in read_forces(plant, own, names).items():
            force[order.index(name)] = F_T
    return forces


def read_forces(plant: MultibodyPlant, context, names: dict) -> dict:
    """Force of each touching pad on the torso, in W, by the pad's name, N."""
    results = plant.get_contact_results_output_port().Eval(context)
    forces = {}
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        # Drake gives the force on the body of its geometry M.
        f_M = info.F_Ac_W().translational()
        name_M, name_N = names[surface.id_M()], names[surface.id_N()]
        forces[name_N if name_M == "torso" else name_M] = (
            f_M if name_M == "torso" else -f_M
        )
    return forces

"""Torsos that are blocks, their pads and how they are pressed."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.scenario.brace import BraceScenario
from brace_drake.torso.contact import (
    MakeTorsoGeometry,
    TorsoContact,
    map_linear_contact,
)
from brace_drake.torso.fitted import FittedTorso, calc_inertia
from brace_drake.torso.measures import (
    Curve,
    TorsoMeasures,
    make_parametric_loft,
)
from brace_drake.torso.pads import Pad, PadPlace
from brace_drake.torso.solid import deepest, fill_outlines
from tools.torso_contact import press_pads

RINGS = (-0.09, 0.0, 0.06)
SIZE = (0.06, 0.08)
CONTACT = TorsoContact(foundation_modulus=4e5)


def block_torso(pads):
    """A block 0.3 m wide and deep, 0.4 m tall, with given pads at ring 1."""
    x = np.array([0.15, 0.15, 0.0, -0.15, -0.15, -0.15, 0.0, 0.15])
    y = np.array([0.0, 0.15, 0.15, 0.15, 0.0, -0.15, -0.15, -0.15])
    heights = np.linspace(-0.2, 0.2, 5)
    outlines = np.stack(
        [
            np.tile(x, (5, 1)),
            np.tile(y, (5, 1)),
            np.repeat(heights[:, None], 8, axis=1),
        ],
        axis=-1,
    )
    axis = np.column_stack([np.zeros((5, 2)), heights])
    solid = fill_outlines(outlines, axis)
    inertia = calc_inertia(solid.vertices, solid.triangles)
    return FittedTorso(solid, deepest(solid), pads, np.zeros(1), inertia)


def flat_pad(side, offset=0.15, size=SIZE):
    """A rectangle that faces the torso at y = side * offset."""
    u, v = 0.5 * np.array(size)
    corners = [(-u, -v), (u, -v), (u, v), (-u, v)]
    vertices = np.array([[a, side * offset, b] for a, b in corners])
    # From above the first corner to the last: towards -y.
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    if side < 0:
        triangles = triangles[:, ::-1]
    place = PadPlace(
        1,
        side,
        np.array([0.0, side * offset, 0.0]),
        np.array([0.0, side, 0.0]),
        np.array([1.0, 0.0, 0.0]),
        size,
    )
    return Pad(place, vertices, triangles)


def shift(x, y, z):
    return RigidTransform([x, y, z])


def curved_loft():
    """A torso whose left and right are unlike."""
    curve = Curve(cobb_deg=40.0, apex=-0.02, axial_rotation_deg=-12.0)
    return make_parametric_loft(TorsoMeasures(curve=curve))


def press_brace(torso, **options):
    """A brace's first millisecond with preloaded pads on a torso.

    Returns:
        The station, its simulator, and the forces on the pads (3, 2, 3) as
        they are with the plant left out.
    """
    scenario = BraceScenario(time_step=2e-4, gravity=0.0)
    for contact in scenario.contacts:
        contact.model, contact.friction = "hydroelastic", 0.0
        contact.preload, contact.damping = 0.003, 0.0
    station = MakeBraceStation(
        scenario, add_geometry=MakeTorsoGeometry(torso), **options
    )
    simulator = Simulator(station.diagram)
    context = simulator.get_mutable_context()
    for name, size in (("leg_command", 18), ("noise", 30)):
        port = station.diagram.GetInputPort(name)
        port.FixValue(context, np.zeros(size))
    simulator.AdvanceTo(0.001)
    numbers = map_linear_contact(
        scenario.contacts[0], torso.mean_effective_area
    )
    alone = press_pads(torso, numbers, [shift(0.0, 0.0, 0.0)])[0]
    return station, simulator, alone.reshape(3, 2, 3)

"""From the linear pad law to Drake's hydroelastic contact and back.

A rigid pad of area A that sinks by d into a compliant layer of thickness H and
modulus E meets the pressure E d / H all over its face, so

    N = (E A / H) d (1 + D d'),    k = E A / H,    c = D k d.

The stiffness maps at every depth, the damping (Hunt and Crossley's, D in s/m)
at one depth only, here the working depth:

    E = k H / A,    D = c / (k d_work).

Two pads that share a preload p make up for that: while both touch, their
depths add up to 2 p, and so do their dampings, to that of the linear law at
d_work = p. Drake's `lagged` and `similar` contact approximations take D;
`sap` would take a relaxation time c / k instead, but no stiction tolerance,
and is not used. `measure_hydroelastic` presses and tells what comes out:
6400 N/m and 150.06 N s/m for 6400 and 150 at 1 mm (the press moves k h on in
its step h), and a resting force linear in depth to 3e-9.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from brace_drake.model.brace_plant import AddBracePlant
from brace_drake.scenario.bench import BenchScenario, Contact
from brace_drake.scenario.bench_brace import brace_of_bench

# A press that contact does not slow down, kg and kg m^2, within a step of
# 10 us: then the force is that at the given depth and speed.
_IMMOVABLE = 1e6
_STEP = 1e-5
_SPEEDS = (-0.01, -0.005, 0.0, 0.005, 0.01)  # m/s


@dataclass(frozen=True)
class MeasuredContact:
    """What pressing one pad into the torso gives.

    Attributes:
        stiffness: Least squares of the resting force through the origin, N/m.
        damping: Slope of force over speed at the working depth, N s/m.
        nonlinearity: Largest deviation of the resting force from stiffness
            times depth, as a part of the largest force.
        damping_at_depth: Slope of force over speed at each depth, N s/m.
        depths: m.
    """

    stiffness: float
    damping: float
    nonlinearity: float
    damping_at_depth: np.ndarray
    depths: np.ndarray


def map_linear_to_hydroelastic(
    stiffness: float,
    damping: float,
    area: float,
    thickness: float,
    working_depth: float,
) -> tuple[float, float]:
    """Modulus E, Pa, and dissipation D, s/m, that give k and c.

    Args:
        stiffness, damping: k, N/m, and c, N s/m, of one pad.
        area: Of the pad's face, m^2.
        thickness: H of the compliant layer, m.
        working_depth: Depth at which the dampings are equal, m.
    """
    modulus = stiffness * thickness / area
    return modulus, damping / (stiffness * working_depth)


def map_hydroelastic_to_linear(
    modulus: float,
    dissipation: float,
    area: float,
    thickness: float,
    working_depth: float,
) -> tuple[float, float]:
    """The inverse: k, N/m, and at the working depth c, N s/m, of one pad."""
    stiffness = modulus * area / thickness
    return stiffness, dissipation * stiffness * working_depth


def with_mapped_hydroelastic(contact: Contact) -> Contact:
    """The contact with modulus and dissipation for its linear k and c.

    The working depth is the preload.
    """
    modulus, dissipation = map_linear_to_hydroelastic(
        contact.stiffness,
        contact.damping,
        contact.pad_size[0] * contact.pad_size[2],
        contact.hydroelastic_thickness,
        contact.preload,
    )
    return replace(
        contact,
        hydroelastic_modulus=modulus,
        hydroelastic_dissipation=dissipation,
    )


def measure_hydroelastic(
    contact: Contact,
    depths: Sequence[float] = (0.00025, 0.0005, 0.001, 0.0015, 0.002, 0.003),
    speeds: Sequence[float] = _SPEEDS,
) -> MeasuredContact:
    """Presses the pad at +y into the torso in Drake and fits k and c.

    Args:
        contact: Its hydroelastic numbers are used; the working depth is its
            preload.
        depths: m, positive.
        speeds: Rates of compression, m/s, with 0 among them.
    """
    depths, speeds = np.asarray(depths), np.asarray(speeds)
    working = contact.preload
    all_depths = np.append(depths, working)
    forces = press_pad(contact, all_depths, speeds)
    slopes = np.polyfit(speeds, forces.T, 1)[0]
    resting = forces[:-1, np.flatnonzero(speeds == 0.0)[0]]
    stiffness = depths @ resting / (depths @ depths)
    deviation = np.abs(resting - stiffness * depths).max()
    return MeasuredContact(
        float(stiffness),
        float(slopes[-1]),
        float(deviation / resting.max()),
        slopes[:-1],
        depths,
    )


def press_pad(
    contact: Contact, depths: np.ndarray, speeds: np.ndarray
) -> np.ndarray:
    """Normal force of the pad at +y, shape (depths, speeds), N."""
    scenario = BenchScenario(
        time_step=_STEP, contact=replace(contact, model="hydroelastic")
    )
    for body in (scenario.ring, scenario.torso):
        body.mass, body.inertia = _IMMOVABLE, np.full(3, _IMMOVABLE)
    scenario.gravity = 0.0
    builder = DiagramBuilder()
    plant = AddBracePlant(builder, brace_of_bench(scenario))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = plant.GetMyMutableContextFromRoot(context)
    plant.get_applied_generalized_force_input_port().FixValue(own, np.zeros(12))
    rest = plant.GetPositions(own)
    forces = np.empty((len(depths), len(speeds)))
    for i, depth in enumerate(depths):
        for j, speed in enumerate(speeds):
            # The pad on the +y side of the torso sinks in towards -y.
            q, v = rest.copy(), np.zeros(12)
            q[5] -= depth - contact.preload
            v[4] = -speed
            plant.SetPositionsAndVelocities(own, np.concatenate([q, v]))
            forces[i, j] = _left_force(plant, own)
    return forces


def _left_force(plant, context) -> float:
    """Force of the pad that presses towards -y, N."""
    results = plant.get_contact_results_output_port().Eval(context)
    torso = set(
        plant.GetCollisionGeometriesForBody(plant.GetBodyByName("torso"))
    )
    total = 0.0
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        is_torso = info.contact_surface().id_M() in torso
        f_y = info.F_Ac_W().translational()[1] * (1.0 if is_torso else -1.0)
        if info.contact_surface().centroid()[1] > 0.0:
            total -= f_y
    return total

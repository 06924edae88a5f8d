"""Accuracy and speed of pads on the torso: the tables behind the defaults.

python tools/torso_contact.py [--measures FILE] [--png FILE]

First table: forces of six pads against those of whole faces on the finest
grid, the largest error of a pad as a part of its load (at least that at rest)
and of the sum of all pads, while all rings move by up to 5 mm along y, 3 mm
along x and z, and 0.02 rad about each axis. Second table: time of a 1 ms step
of a plant of three free rings and the torso, of the processor, the least of
many short stretches: whole faces and points, then the discrete contact
approximations with the default points. The picture shows both.
"""

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import replace

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from brace_drake.core.resources import scenario_path
from brace_drake.scenario.brace import Contact
from brace_drake.torso.contact import (
    AddTorsoContact,
    TorsoContact,
    map_linear_contact,
)
from brace_drake.torso.fitted import (
    PAD_RESOLUTION,
    RESOLUTION,
    FittedTorso,
    fit_torso,
)
from brace_drake.torso.measures import LoadMeasures, make_parametric_loft
from brace_drake.torso.personalize import RING_HEIGHTS

MOTIONS = {
    "rest": RigidTransform(),
    "y 1 mm": RigidTransform([0.0, -0.001, 0.0]),
    "y 5 mm": RigidTransform([0.0, -0.005, 0.0]),
    "x 3 mm": RigidTransform([0.003, -0.001, 0.0]),
    "z 3 mm": RigidTransform([0.0, -0.001, 0.003]),
    "roll": RigidTransform(RollPitchYaw(0.02, 0.0, 0.0), [0.0, 0.0, 0.0]),
    "pitch": RigidTransform(RollPitchYaw(0.0, 0.02, 0.0), [0.0, 0.0, 0.0]),
    "yaw": RigidTransform(RollPitchYaw(0.0, 0.0, 0.02), [0.0, 0.0, 0.0]),
}
WHOLE = (0, 0)
DEFAULT = tuple(Contact().pad_points)
FINEST = 0.0075
# Resolutions elsewhere and under pads, and what pads are.
CASES = (
    *((r, r, WHOLE) for r in (0.03, 0.025, 0.02, 0.015)),
    *((RESOLUTION, r, DEFAULT) for r in (0.025, 0.012, 0.008, 0.005)),
    *((RESOLUTION, PAD_RESOLUTION, n) for n in ((2, 2), (3, 3), (4, 4))),
)
APPROXIMATIONS = {
    "lagged": DiscreteContactApproximation.kLagged,
    "similar": DiscreteContactApproximation.kSimilar,
    "sap": DiscreteContactApproximation.kSap,
    "tamsi": DiscreteContactApproximation.kTamsi,
}
STEP, STEPS, REPEATS = 1e-3, 4, 15
_TICKS_US = 300, 500, 1000, 2000, 5000


# A press that contact does not move, kg, within a step of 10 us: then the
# force is that at the given pose.
_IMMOVABLE = 1e6
PRESS_STEP = 1e-5
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
    diagram, plant, geometries = MakeRingsAndTorso(torso, contact, PRESS_STEP)
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


def make(loft, resolution, pad_resolution, points):
    """A fitted torso and its contact numbers."""
    linear = Contact(pad_points=list(points))
    size = linear.pad_size[0], linear.pad_size[2]
    torso = fit_torso(loft, RING_HEIGHTS, size, resolution, pad_resolution)
    return torso, map_linear_contact(linear, torso.mean_effective_area)


def pad_forces(torso, contact):
    """Forces on the torso (motions, pads, 3) and along the pads' normals."""
    forces = press_pads(torso, contact, list(MOTIONS.values()))
    normals = np.array([pad.place.normal for pad in torso.pads])
    return forces, -np.einsum("mpi,pi->mp", forces, normals)


def calc_errors(found, expected):
    """Largest error of a pad at each motion, and that of the sum, %."""
    (forces, along), (finest, normal) = found, expected
    load = np.maximum(np.abs(normal), np.abs(normal[0]))
    single = 100.0 * np.max(np.abs(along - normal) / load, axis=1)
    total = np.linalg.norm((forces - finest).sum(axis=1))
    return single, 100.0 * total / np.linalg.norm(finest.sum(axis=1))


def time_step(torso, contact):
    """Least time of a plant's step, s, and its contact faces."""
    diagram, plant, _ = MakeRingsAndTorso(torso, contact, STEP, 0.85, 40.0)
    context = diagram.CreateDefaultContext()
    simulator = Simulator(diagram, context)
    simulator.AdvanceTo(STEPS * STEP)
    best = np.inf
    for i in range(REPEATS):
        start = time.process_time()
        simulator.AdvanceTo((i + 2) * STEPS * STEP)
        best = min(best, (time.process_time() - start) / STEPS)
    own = plant.GetMyContextFromRoot(context)
    results = plant.get_contact_results_output_port().Eval(own)
    faces = sum(
        results.hydroelastic_contact_info(i).contact_surface().num_faces()
        for i in range(results.num_hydroelastic_contacts())
    )
    return best, faces


def print_cases(loft):
    """Both tables of all cases; their errors and times."""
    expected = pad_forces(*make(loft, FINEST, FINEST, WHOLE))
    names = " ".join(f"{name:>6}" for name in MOTIONS)
    print(f"{'error of a pad, %':21} {names}    sum  faces us a step")
    table = {}
    for case in CASES:
        torso, contact = make(loft, *case)
        single, total = calc_errors(pad_forces(torso, contact), expected)
        best, faces = time_step(torso, contact)
        row = " ".join(f"{e:6.2f}" for e in single)
        print(
            f"{_label(case):21} {row} {total:6.2f} {faces:6d} {1e6 * best:9.0f}"
        )
        table[case] = single.max(), total, best
    return table


def _label(case):
    points = case[2]
    what = "whole" if points == WHOLE else f"{points[0]} x {points[1]}"
    return f"{what}, {1e3 * case[1]:g} mm"


def print_approximations(loft):
    """Times of a step with the default pads."""
    torso, contact = make(loft, RESOLUTION, PAD_RESOLUTION, DEFAULT)
    for name, kind in APPROXIMATIONS.items():
        best, _ = time_step(torso, replace(contact, approximation=kind))
        print(f"{name:21} {1e6 * best:6.0f} us a step")


def draw(table, path):
    """Errors over facets, and over the time of a step."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    over_facet, over_time = figure.subplots(1, 2, sharey=True)
    groups = {
        "whole faces": [c for c in CASES if c[2] == WHOLE],
        f"{DEFAULT[0]} x {DEFAULT[1]} points": [
            c for c in CASES if c[2] == DEFAULT
        ],
    }
    colours = ("#3b6ea5", "#c8553d")
    for (name, cases), colour in zip(groups.items(), colours, strict=True):
        cases = sorted(set(cases), key=lambda c: c[1])
        facets = [1e3 * case[1] for case in cases]
        single, total, best = np.array([table[case] for case in cases]).T
        over_facet.plot(facets, single, "o-", color=colour, label=name)
        over_facet.plot(facets, total, "o:", color=colour)
        over_time.plot(1e6 * best, single, "o", color=colour)
    for case in CASES:
        if case[2] not in (WHOLE, DEFAULT):
            error, _, best = table[case]
            over_time.plot(1e6 * best, error, "s", color="#666666")
            text = f"{case[2][0]} x {case[2][1]}"
            over_time.annotate(
                text,
                (1e6 * best, error),
                (5, 5),
                textcoords="offset points",
                fontsize=8,
            )
    over_facet.set_xlabel("facet under pads, mm")
    over_facet.set_ylabel("error of force, %: pad (solid), sum (dotted)")
    over_facet.set_ylim(bottom=0.0)
    over_facet.legend(frameon=False)
    over_time.set_xscale("log")
    over_time.set_xticks(_TICKS_US, [f"{tick}" for tick in _TICKS_US])
    over_time.minorticks_off()
    over_time.set_xlabel("plant step, us of the processor")
    for axes in (over_facet, over_time):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def main():
    """Prints the tables; draws them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    nominal = scenario_path("torso_nominal.measures.yaml")
    parser.add_argument("--measures", default=nominal)
    parser.add_argument("--png", metavar="FILE", help="also draw a picture")
    args = parser.parse_args()
    loft = make_parametric_loft(LoadMeasures(args.measures))
    table = print_cases(loft)
    print_approximations(loft)
    if args.png:
        draw(table, args.png)


if __name__ == "__main__":
    main()

"""Accuracy and speed of pads on the torso: the tables behind the defaults.

python tools/torso_contact.py [--measures FILE] [--quick]

First table: forces of six pads against those on the finest grid, the largest
error of a pad as a part of its load (at least that at rest) and of the sum of
all pads, while all rings move by up to 5 mm along y, 3 mm along x and z, and
0.02 rad about each axis. Second table: time of a step of a plant of three free
rings and the torso, the least of several.
"""

import argparse
import os
import time
from dataclasses import replace

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import DiscreteContactApproximation
from pydrake.systems.analysis import Simulator

from brace_drake.resources import scenario_path
from brace_drake.scenario.bench import Contact
from brace_drake.torso.contact import map_linear_contact
from brace_drake.torso.fitted import fit_torso
from brace_drake.torso.measures import LoadMeasures
from brace_drake.torso.parametric import make_parametric_loft
from brace_drake.torso.personalize import RING_HEIGHTS
from brace_drake.torso.press import MakeRingsAndTorso, press_pads

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
RESOLUTIONS = (0.01, 0.015, 0.02, 0.025, 0.03)
FINEST = 0.0075
APPROXIMATIONS = {
    "lagged": DiscreteContactApproximation.kLagged,
    "similar": DiscreteContactApproximation.kSimilar,
    "sap": DiscreteContactApproximation.kSap,
    "tamsi": DiscreteContactApproximation.kTamsi,
}
STEPS, REPEATS = 20, 5


def make(loft, resolution):
    """A fitted torso and its contact numbers."""
    contact = Contact()
    size = contact.pad_size[0], contact.pad_size[2]
    torso = fit_torso(loft, RING_HEIGHTS, size, resolution)
    return torso, map_linear_contact(contact, torso.mean_effective_area)


def pad_forces(torso, contact):
    """Forces on the torso (motions, pads, 3) and along the pads' normals."""
    forces = press_pads(torso, contact, list(MOTIONS.values()))
    normals = np.array([pad.place.normal for pad in torso.pads])
    return forces, -np.einsum("mpi,pi->mp", forces, normals)


def print_accuracy(loft):
    """The first table."""
    finest, normal = pad_forces(*make(loft, FINEST))
    load = np.maximum(np.abs(normal), np.abs(normal[0]))
    names = " ".join(f"{name:>7}" for name in MOTIONS)
    print(f"error of a pad, %        {names}    sum")
    for resolution in RESOLUTIONS:
        torso, contact = make(loft, resolution)
        forces, along = pad_forces(torso, contact)
        error = 100.0 * np.max(np.abs(along - normal) / load, axis=1)
        total = np.linalg.norm((forces - finest).sum(axis=1))
        total *= 100.0 / np.linalg.norm(finest.sum(axis=1))
        row = " ".join(f"{e:7.2f}" for e in error)
        count = len(torso.solid.tetrahedra)
        print(f"{1e3 * resolution:5.1f} mm {count:6d} tets {row} {total:6.2f}")


def time_step(torso, contact, step):
    """Least time of a plant's step, s, and its contact faces."""
    diagram, plant, _ = MakeRingsAndTorso(torso, contact, step, 0.85, 40.0)
    context = diagram.CreateDefaultContext()
    simulator = Simulator(diagram, context)
    simulator.Initialize()
    best = np.inf
    for i in range(REPEATS):
        start = time.perf_counter()
        simulator.AdvanceTo((i + 1) * STEPS * step)
        best = min(best, (time.perf_counter() - start) / STEPS)
    own = plant.GetMyContextFromRoot(context)
    results = plant.get_contact_results_output_port().Eval(own)
    faces = sum(
        results.hydroelastic_contact_info(i).contact_surface().num_faces()
        for i in range(results.num_hydroelastic_contacts())
    )
    return best, faces


def print_speed(loft, steps):
    """The second table."""
    for resolution in RESOLUTIONS[1:]:
        torso, contact = make(loft, resolution)
        for step in steps:
            cells = []
            for name, kind in APPROXIMATIONS.items():
                best, faces = time_step(
                    torso, replace(contact, approximation=kind), step
                )
                cells.append(f"{name} {1e6 * best:6.0f}")
            print(
                f"{1e3 * resolution:5.1f} mm, {faces:4d} faces,"
                f" {1e3 * step:g} ms, us a step: {', '.join(cells)}"
            )


def main():
    """Prints both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    nominal = scenario_path("torso_nominal.measures.yaml")
    parser.add_argument("--measures", default=nominal)
    parser.add_argument("--quick", action="store_true", help="1 ms only")
    args = parser.parse_args()
    loft = make_parametric_loft(LoadMeasures(args.measures))
    print_accuracy(loft)
    print_speed(loft, (1e-3,) if args.quick else (1e-3, 5e-4, 2e-4))


if __name__ == "__main__":
    main()

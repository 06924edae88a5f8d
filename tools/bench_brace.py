"""Speed of the whole brace, and of its hydroelastic contact."""

import time

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.core.resources import scenario_path
from brace_drake.kinematics import static_leg_forces
from brace_drake.model.brace_plant import AddBracePlant
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.simulate import without_garbage_collection
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.brace import Contact
from brace_drake.scenario.brace_numbers import (
    geometry_of,
    pack_brace,
    pack_rings,
)
from brace_drake.torso.contact import MakeTorsoGeometry
from brace_drake.torso.fitted import PAD_RESOLUTION, fit_torso
from brace_drake.torso.measures import LoadMeasures, make_parametric_loft
from brace_drake.torso.personalize import RING_HEIGHTS
from tests.brace_runs import brace, way_to

BRACE_DURATION = 3.0
CONTACT_DURATION = 1.0
# Hydroelastic braces: mechanism, on a torso's mesh or on half spaces, step.
HYDROELASTIC = (
    ("task_space", "mesh", 1e-3),
    ("task_space", "half spaces", 1e-3),
    ("articulated", "mesh", 1e-3),
    ("articulated", "half spaces", 1e-3),
)
# What the whole brace is timed as: mechanism, contact, plant step.
BRACES = (
    ("task_space", "linear", 5e-4),
    ("articulated", "none", 1e-3),
    ("articulated", "linear", 1e-3),
    ("articulated", "linear", 5e-4),
)


def run_brace(mechanism, contact, step):
    """Times of the brace's closed loop at 1 kHz and of its bare plant, s.

    Of the processor, as both run on one core.
    """
    scenario = brace(mechanism, contact, time_step=step)
    X = np.zeros(18)
    X[1::6] = -0.004, -0.008, -0.006
    controller = MakeController(scenario.control, pack_rings(scenario))
    desired = way_to(X, BRACE_DURATION)
    station = MakeBraceStation(scenario, controller, desired).diagram
    builder = DiagramBuilder()
    plant = AddBracePlant(builder, scenario)
    bare = builder.Build()
    if plant.num_actuators():
        # Legs that carry the rings; falling they would meet their stops.
        held = static_leg_forces(
            geometry_of(pack_brace(scenario)), np.zeros(18), _weights(scenario)
        )
    times = []
    for diagram in (station, bare):
        simulator = Simulator(diagram)
        context = simulator.get_mutable_context()
        if diagram is bare and plant.num_actuators():
            plant.get_actuation_input_port().FixValue(
                plant.GetMyContextFromRoot(context), held
            )
        kept = [s.GetMyContextFromRoot(context) for s in diagram.GetSystems()]
        simulator.AdvanceTo(0.02)
        start = time.process_time()
        simulator.AdvanceTo(BRACE_DURATION)
        times.append(time.process_time() - start)
        del kept
    return times


def _weights(scenario):
    """What the legs have to put on the rings against gravity (18,)."""
    W = np.zeros((3, 6))
    W[:, 2] = scenario.ring.mass * scenario.gravity
    return W.ravel()


def time_braces():
    """Prints the rows of the whole brace."""
    print(f"{'the whole brace':44} {'x real':>8} {'x bare plant':>13}")
    for mechanism, contact, step in BRACES:
        closed, bare = np.min(
            [run_brace(mechanism, contact, step) for _ in range(3)], axis=0
        )
        label = f"{mechanism}, contact {contact}, {1e3 * step:g} ms"
        speed = (BRACE_DURATION - 0.02) / closed
        print(f"{label:44} {speed:8.2f} {closed / bare:13.2f}")


def run_contact(mechanism, add_geometry, step):
    """Times of a hydroelastic brace and of its plant alone, s.

    The plant alone steps through the same contact: it replays the forces that
    the closed loop has put on it, held in each step. Both of the processor;
    the first once more by the clock.
    """
    scenario = brace(mechanism, "hydroelastic", time_step=step)
    X = np.zeros(18)
    X[1::6] = -0.004, -0.008, -0.006

    def make_closed():
        controller = MakeController(scenario.control, pack_rings(scenario))
        desired = way_to(X, CONTACT_DURATION)
        return MakeBraceStation(
            scenario, controller, desired, add_geometry=add_geometry
        )

    forces = record_forces(make_closed(), step)
    closed = make_closed()
    bare, pose = make_replay(scenario, add_geometry, forces, step)
    time_closed, clock, end = time_run(closed.diagram, closed.plant)
    time_bare, _, bare_end = time_run(bare, pose)
    if np.abs(end - bare_end).max() > 1e-4:
        raise RuntimeError("the replay left the motion of the closed loop")
    return time_closed, clock, time_bare


def record_forces(station, step):
    """Forces on the plant, applied and of actuators, at each step."""
    plant, rows = station.plant, []
    ports = [plant.get_applied_generalized_force_input_port()]
    ports += [plant.get_actuation_input_port()] if plant.num_actuators() else []

    def watch(root):
        at = root.get_time() / step
        if abs(at - round(at)) < 1e-9:
            own = plant.GetMyContextFromRoot(root)
            rows.append([port.Eval(own).copy() for port in ports])

    simulator = Simulator(station.diagram)
    simulator.set_monitor(watch)
    simulator.AdvanceTo(CONTACT_DURATION)
    return [np.array(column) for column in zip(*rows, strict=True)]


def make_replay(scenario, add_geometry, forces, step):
    """The plant with forces (N, size) as native sources; diagram, plant."""
    builder = DiagramBuilder()
    plant = AddBracePlant(builder, scenario, add_geometry)
    ports = [plant.get_applied_generalized_force_input_port()]
    ports += [plant.get_actuation_input_port()] if plant.num_actuators() else []
    for port, rows in zip(ports, forces, strict=True):
        edges = (np.arange(len(rows) + 1) - 0.5) * step
        held = np.vstack([rows, rows[-1:]]).T
        source = TrajectorySource(
            PiecewisePolynomial.ZeroOrderHold(edges, held)
        )
        source = builder.AddSystem(source)
        builder.Connect(source.get_output_port(), port)
    return builder.Build(), plant


def time_run(diagram, plant):
    """Times of a run, of the processor and by the clock, and its end."""
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    kept = [s.GetMyContextFromRoot(context) for s in diagram.GetSystems()]
    simulator.AdvanceTo(0.02)
    with without_garbage_collection():
        start = time.process_time(), time.perf_counter()
        simulator.AdvanceTo(CONTACT_DURATION)
        spent = time.process_time() - start[0], time.perf_counter() - start[1]
    del kept
    return *spent, plant.GetPositions(plant.GetMyContextFromRoot(context))


def time_contact(repeats=3):
    """Prints the rows of the hydroelastic brace."""
    loft = make_parametric_loft(
        LoadMeasures(scenario_path("torso_nominal.measures.yaml"))
    )
    size = Contact().pad_size[[0, 2]]
    torso = fit_torso(
        loft, RING_HEIGHTS, tuple(size), pad_resolution=PAD_RESOLUTION
    )
    print(
        f"{'hydroelastic':44} {'x real':>8} {'by clock':>9}"
        f" {'x plant alone':>14}"
    )
    for mechanism, kind, step in HYDROELASTIC:
        add = MakeTorsoGeometry(torso) if kind == "mesh" else None
        closed, clock, bare = np.min(
            [run_contact(mechanism, add, step) for _ in range(repeats)], axis=0
        )
        label = f"{mechanism}, {kind}, {1e3 * step:g} ms"
        span = CONTACT_DURATION - 0.02
        print(
            f"{label:44} {span / closed:8.2f} {span / clock:9.2f}"
            f" {closed / bare:14.2f}",
            flush=True,
        )

"""Times what must be fast and prints one table, with ratios of one run.

python tools/bench.py [--campaign FOLDER]
    [--quick | --learning | --contact | --scale]
"""

import argparse
import dataclasses
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import bench_scale
import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.brace_plant import AddBraceBodies, AddBracePlant
from brace_drake.brace_station import MakeBraceStation
from brace_drake.campaign import LoadCampaign
from brace_drake.fit.campaign_fit import fit_campaign
from brace_drake.gap.diagnose import diagnose
from brace_drake.kinematics import static_leg_forces
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.make import full_task
from brace_drake.learning.subjects import EffectRange, SubjectRanges
from brace_drake.learning.task import LearningTask
from brace_drake.resources import scenario_path
from brace_drake.scenario.bench import BenchScenario, Contact
from brace_drake.scenario.bench_brace import brace_of_bench
from brace_drake.scenario.brace_numbers import pack_brace, pack_rings
from brace_drake.simulate import SimulateBench, without_garbage_collection
from brace_drake.station import MakeBenchStation
from brace_drake.systems.brace_controllers import MakeController
from brace_drake.torso.contact import MakeTorsoGeometry
from brace_drake.torso.fitted import PAD_RESOLUTION, fit_torso
from brace_drake.torso.measures import LoadMeasures
from brace_drake.torso.parametric import make_parametric_loft
from brace_drake.torso.personalize import RING_HEIGHTS
from brace_drake.twin.bench_twin import BenchTwin
from brace_drake.twin.reference import (
    MakeReference,
    reference_of_run,
)
from tests.brace_runs import brace, way_to
from tests.learning_tasks import random_policy

EXAMPLE = Path(__file__).resolve().parents[1] / "tests" / "data" / "example"
DURATION = 12.0
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


def best_of(count, function):
    """Shortest of several timings, s."""
    times = []
    for _ in range(count):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def bare_plant(step):
    """Time of two floating bodies without forces over a run, s."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(step))
    scenario = BenchScenario()
    scenario.gravity = 0.0
    AddBraceBodies(plant, brace_of_bench(scenario))
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    diagram = builder.Build()
    return best_of(3, lambda: Simulator(diagram).AdvanceTo(DURATION))


def closed_loop(run, step):
    """Times of the Drake diagram and of the compiled rollout, s."""
    scenario = BenchScenario()
    scenario.time_step = step
    reference = MakeReference(*reference_of_run(run))
    station = MakeBenchStation(scenario, reference)
    end = run.time_s[-1] - run.time_s[0]
    SimulateBench(station, 0.1)
    diagram = best_of(3, lambda: SimulateBench(station, end))
    # A twin remembers what it has simulated.
    twins = [BenchTwin(scenario) for _ in range(5)]
    subject = np.array([p.nominal for p in twins[0].subject])
    motion = twins[0].motion(run)
    rollout = best_of(5, lambda: twins.pop().simulate(motion, subject))
    return diagram, rollout


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
            pack_brace(scenario).geometry, np.zeros(18), _weights(scenario)
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


def time_env(task):
    """Env steps a second of the processor over an episode."""
    env = RlpicEnv(task)
    env.reset(seed=0)
    env.step(np.zeros(env.action_space.shape))
    env.reset(seed=0)
    over, start = False, time.process_time()
    while not over:
        *_, ended, cut, _ = env.step(np.zeros(env.action_space.shape))
        over = ended or cut
    return env.task.max_steps / (time.process_time() - start)


def time_learning():
    """Prints the rows of learning: envs, a decision, an update."""
    print(f"{'learning':44} {'steps / s':>10}")
    effects = [EffectRange("coulomb_friction"), EffectRange("force_lag")]
    for label, task in (
        ("one stage", LearningTask()),
        (
            "one stage, two effects",
            LearningTask(subjects=SubjectRanges(effects=effects)),
        ),
        ("three stages", full_task()),
        ("one stage, Drake diagram", LearningTask(backend="diagram")),
        (
            "three stages, Drake diagram",
            dataclasses.replace(full_task(), backend="diagram", max_steps=60),
        ),
    ):
        speed = max(time_env(task) for _ in range(3))
        print(f"{label:44} {speed:10.0f}")
    policy = random_policy(LearningTask(), hidden=256)
    observation = np.full(7, 1e-3)
    policy.act(observation)
    decision = best_of(2000, lambda: policy.act(observation))
    print(f"{'a decision of a policy, us':44} {1e6 * decision:10.1f}")
    try:
        from brace_drake.training.learner import Learner
        from brace_drake.training.numbers import TrainingNumbers
    except ImportError:
        return
    learner = Learner(LearningTask(), TrainingNumbers())
    learner.advance()
    start = time.process_time()
    learner.advance()
    speed = learner.numbers.horizon / (time.process_time() - start)
    print(f"{'training, updates included':44} {speed:10.0f}")


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--campaign", default=str(EXAMPLE))
    parser.add_argument("--quick", action="store_true", help="runs only")
    parser.add_argument("--learning", action="store_true", help="learning only")
    parser.add_argument("--contact", action="store_true", help="contact only")
    parser.add_argument(
        "--scale", action="store_true", help="scaling of a diagnosis only"
    )
    args = parser.parse_args()
    if args.scale:
        bench_scale.print_table(bench_scale.ROWS.split(","), args.campaign)
        return
    if args.contact:
        time_contact()
        return
    if args.learning:
        time_learning()
        return
    campaign = LoadCampaign(args.campaign)
    run = next(r for r in campaign.runs if r.contact and r.motion == "push")
    print(f"{'what':44} {'s':>8} {'x bare plant':>13}")
    for step in (5e-4, 2e-4):
        bare = bare_plant(step)
        diagram, rollout = closed_loop(run, step)
        for name, value in (
            ("bare plant", bare),
            ("closed loop, Drake diagram", diagram),
            ("closed loop, compiled rollout", rollout),
        ):
            label = f"{name}, 12 s at {1e3 * step:g} ms"
            print(f"{label:44} {value:8.3f} {value / bare:13.2f}")
    time_braces()
    time_contact()
    time_learning()
    if args.quick:
        return
    jobs = os.cpu_count() or 1
    for name, function in (("fit", fit_campaign), ("diagnose", diagnose)):
        label = f"{name} of {campaign.name}, {jobs} threads"
        print(f"{label:44} {best_of(1, lambda f=function: f(campaign)):8.1f}")
    bench_scale.print_table(bench_scale.ROWS.split(","), args.campaign)


if __name__ == "__main__":
    main()

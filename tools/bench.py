"""Times what must be fast and prints one table, with ratios of one run.

python tools/bench.py [--campaign FOLDER]
    [--quick | --learning | --contact | --scale]
"""

import argparse
import dataclasses
import os
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import bench_brace
import bench_scale
import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.reference import (
    MakeBraceReference,
)
from brace_drake.devices.twin import Request
from brace_drake.diagnosis import diagnose
from brace_drake.identification.subject.campaign_fit import fit_campaign
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.subjects import EffectRange, SubjectRanges
from brace_drake.learning.task import (
    LearningTask,
    full_task,
    load_task_scenario,
)
from brace_drake.learning.vector.env import RlpicVectorEnv
from brace_drake.model.brace_plant import AddBraceBodies
from brace_drake.model.brace_station import MakeControlledBrace
from brace_drake.model.simulate import SimulateStation
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import SaveScenario
from tests.learning_tasks import random_policy

EXAMPLE = Path(__file__).resolve().parents[1] / "tests" / "data" / "example"
DURATION = 12.0


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
    AddBraceBodies(plant, scenario)
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    diagram = builder.Build()
    return best_of(3, lambda: Simulator(diagram).AdvanceTo(DURATION))


def closed_loop(run, step):
    """Times of the Drake diagram and of the compiled rollout, s."""
    scenario = BenchScenario()
    scenario.time_step = step
    reference = MakeBraceReference(run, scenario.stages, np.zeros(6))
    station = MakeControlledBrace(scenario, reference)
    end = run.time_s[-1] - run.time_s[0]
    SimulateStation(station, 0.1)
    diagram = best_of(3, lambda: SimulateStation(station, end))
    # A twin remembers what it has simulated.
    twins = [BenchTwin(scenario) for _ in range(5)]
    subject = np.array([p.nominal for p in twins[0].subject])
    motion = twins[0].motion(run)
    rollout = best_of(5, lambda: twins.pop().simulate(motion, subject))
    return diagram, rollout


def copies(run, step, effect=None):
    """Times of one copy of a bench, and of as many as go side by side, s."""
    scenario = BenchScenario()
    scenario.time_step = step
    uses = []
    if effect is not None:
        card = BenchTwin(scenario).effects()[effect]
        uses = [(card, card.starts()[0])]

    def simulate(count):
        # A twin remembers what it has simulated.
        twin = BenchTwin(scenario)
        usual = np.array([p.nominal for p in twin.subject])
        motion = twin.motion(run)
        return twin.simulate_each(
            [
                Request(motion, usual * (1.0 + 0.01 * i), uses)
                for i in range(count)
            ]
        )

    simulate(2)
    return tuple(best_of(5, lambda n=n: simulate(n)) for n in (1, COUNT))


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


def time_vector_env(task, count=16):
    """Env steps a second of the processor, of episodes side by side."""
    envs = RlpicVectorEnv(count, task, "SameStep")
    actions = np.zeros(envs.action_space.shape)
    envs.reset(seed=0)
    envs.step(actions)
    start = time.process_time()
    for _ in range(task.max_steps):
        envs.step(actions)
    return count * task.max_steps / (time.process_time() - start)


def hydroelastic_task(folder):
    """The task on pads of hydroelastic contact; it runs on the diagram."""
    task = LearningTask(backend="diagram")
    scenario = load_task_scenario(task)
    scenario.contact.ring2.model = "hydroelastic"
    file = Path(folder) / "hydroelastic.scenario.yaml"
    SaveScenario(scenario, file)
    return dataclasses.replace(task, scenario=str(file), max_steps=60)


def time_learning():
    """Prints the rows of learning: envs, a decision, an update."""
    with tempfile.TemporaryDirectory() as folder:
        time_envs(folder)
    policy = random_policy(LearningTask(), hidden=256)
    observation = np.full(7, 1e-3)
    policy.act(observation)
    decision = best_of(2000, lambda: policy.act(observation))
    print(f"{'a decision of a policy, us':44} {1e6 * decision:10.1f}")
    try:
        from brace_drake.learning.training.learner import Learner
        from brace_drake.learning.training.numbers import TrainingNumbers
    except ImportError:
        return
    for envs in (1, 8):
        learner = Learner(LearningTask(), TrainingNumbers(envs=envs))
        learner.advance()
        start = time.process_time()
        learner.advance()
        speed = learner.numbers.horizon / (time.process_time() - start)
        label = f"training, updates included, envs: {envs}"
        print(f"{label:44} {speed:10.0f}")


def time_envs(folder):
    """Prints the rows of the envs; `folder` is for their files."""
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
        ("one stage, hydroelastic, diagram", hydroelastic_task(folder)),
        (
            "three stages, Drake diagram",
            dataclasses.replace(full_task(), backend="diagram", max_steps=60),
        ),
    ):
        speed = max(time_env(task) for _ in range(3))
        print(f"{label:44} {speed:10.0f}")
        if label in ("one stage", "three stages"):
            side = max(time_vector_env(task) for _ in range(3))
            label = f"{label}, 16 episodes side by side"
            print(f"{label:44} {side:10.0f} {side / speed:6.2f} x one")


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--campaign", default=str(EXAMPLE))
    parser.add_argument("--quick", action="store_true", help="runs only")
    parser.add_argument("--learning", action="store_true", help="learning only")
    parser.add_argument("--contact", action="store_true", help="contact only")
    parser.add_argument(
        "--scale",
        action="store_true",
        help="a diagnosis alone, and how it grows",
    )
    args = parser.parse_args()
    if args.scale:
        bench_scale.print_table(bench_scale.ROWS.split(","), args.campaign)
        return
    if args.contact:
        bench_brace.time_contact()
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
    for effect in (None, "relaxation", "coulomb_friction"):
        alone, together = copies(run, 1e-3 / 3.0, effect)
        label = f"{COUNT} copies of one, {effect or 'no effect'}"
        print(f"{label:44} {together:8.3f} {together / alone:8.2f} x one")
    bench_brace.time_braces()
    bench_brace.time_contact()
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

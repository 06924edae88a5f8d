"""A policy on a device: the simulation's tracking, and its bounds."""

import csv
import tempfile
import unittest
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest import mock

import numpy as np
from pydrake.systems.analysis import Simulator

from brace_drake.core.errors import LinkError, PolicyError
from brace_drake.devices.motions.reference import reference_at_ticks
from brace_drake.learning.compiled_loop import CompiledLoop
from brace_drake.learning.deployment import (
    MakePolicyControl,
    load_policy_scenario,
    motion_of_task,
)
from brace_drake.learning.episode import PreparedTask
from brace_drake.learning.policy import SavePolicy
from brace_drake.learning.subjects import NOMINAL
from brace_drake.learning.task import full_task
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.brace_plant import BracePlant
from brace_drake.link.operation.motion import desired_at_ticks
from brace_drake.link.operation.station import OpenDevice
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.model.systems.stiffness_limiter import StiffnessLimiter
from brace_drake.scenario.brace import BenchScenario
from tests.commands import run_command
from tests.emulated_devices import PATIENT, PATIENT_LIMITS, emulated
from tests.learning_tasks import random_policy, short_task

# A motion fast enough that the stiffness matters.
TASK = short_task(40, motion_time=2.0)
# So wide that the policy's own law is what limits.
WIDE = {"stiffness": 6e4, "stiffness_rate": 1e7}
TICKS = 2000


def bench_of(brace):
    """The same bench as a brace of stage 2 alone."""
    bench = BenchScenario(time_step=brace.time_step)
    bench.torso.posture_stiffness = brace.torso.posture_stiffness
    return bench


def simulate(policy, ticks=TICKS, along=1):
    """y of the ring(s) and K_d in use at each tick, by the compiled laws."""
    task, law = policy.task, policy.law
    prepared, every = PreparedTask(task), round(1e3 * task.sample_time)
    loop = CompiledLoop(prepared.scenario, 1e-3, task.motion_time)
    held = law.action(law.start)
    episode = prepared.draw(np.random.default_rng(0), NOMINAL)
    loop.start(episode, prepared.stiffness(held))
    y, K = [], []
    for i in range(ticks):
        y.append(loop.truth().position[along])
        K.append(loop.stiffness[along].copy())
        if i % every == 0:
            action = policy.act_on(loop.estimate, loop.desired)
            held = law.limit(action, held)
        loop.advance(prepared.stiffness(held))
    return np.array(y), np.array(K)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


class TestHost(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.policy = random_policy(TASK)
        cls.brace = load_policy_scenario(cls.policy)
        motion = motion_of_task(TASK)
        cls.desired = reference_at_ticks(motion.time, motion.samples, 1000.0)

    def follow(self, limits):
        control = MakePolicyControl(self.policy, self.brace, limits)
        plant = BenchPlant(bench_of(self.brace), seed=None)
        y, K, u = np.empty(TICKS), np.empty(TICKS), plant.hold
        for i in range(TICKS):
            readings = plant.advance(u).copy()
            y[i] = plant.bodies[5]
            u = control.Tick(readings, self.desired[i]).copy()
            K[i] = control.stiffness[0]
        return y, K

    def test_on_an_exact_bench_it_is_the_simulation(self):
        y, K = self.follow(DEFAULT._replace(**WIDE))
        y_simulated, K_simulated = simulate(self.policy)
        self.assertGreater(np.ptp(K), 20000.0)
        np.testing.assert_allclose(K, K_simulated, rtol=1e-6)
        np.testing.assert_allclose(y, y_simulated, atol=1e-8)

    def test_a_policy_of_three_rings_is_the_simulation_on_a_whole_brace(self):
        task = replace(full_task(), max_steps=8, motion_time=1.0)
        policy = random_policy(task)
        scenario = load_policy_scenario(policy)
        motion = motion_of_task(task, 3)
        desired = desired_at_ticks(motion, 1000.0)
        np.testing.assert_allclose(
            desired[-1, 0], motion.samples[-1, 0], atol=1e-12
        )
        control = MakePolicyControl(policy, scenario, DEFAULT._replace(**WIDE))
        plant, ticks = BracePlant(scenario, seed=None), 250
        y, K, u = np.empty((ticks, 3)), np.empty((ticks, 3)), plant.hold
        for i in range(ticks):
            readings = plant.advance(u).copy()
            y[i] = plant.bodies[5:20:7]
            u = control.Tick(readings, desired[i]).copy()
            K[i] = control.stiffness
        y_simulated, K_simulated = simulate(policy, ticks, slice(1, None, 6))
        self.assertGreater(np.ptp(K, axis=0).min(), 2000.0)
        np.testing.assert_allclose(K, K_simulated, rtol=1e-6)
        np.testing.assert_allclose(y, y_simulated, atol=1e-8)

    def test_the_limits_hold_whatever_the_policy_asks(self):
        _, K = self.follow(DEFAULT)
        self.assertLessEqual(K.max(), DEFAULT.stiffness)
        self.assertGreater(K.max(), 0.9 * DEFAULT.stiffness)
        steps = np.abs(np.diff(K))
        self.assertLessEqual(steps.max(), 1e-3 * DEFAULT.stiffness_rate + 1e-9)
        self.assertGreater(steps.max(), 0.9e-3 * DEFAULT.stiffness_rate)

    def test_a_ring_found_away_is_brought_home_softly(self):
        control = MakePolicyControl(self.policy, self.brace, DEFAULT)
        plant = BenchPlant(bench_of(self.brace), seed=None)
        plant.with_torso = False
        plant.bodies[5] += 0.003
        control.Reset()
        control.GoHome(400)
        u, y, forces = plant.hold, [], []
        for _ in range(1000):
            u = control.Tick(plant.advance(u), np.zeros(3)).copy()
            y.append(plant.bodies[5])
            forces.append(u - plant.hold)
        self.assertAlmostEqual(y[0], 0.003, delta=1e-5)
        self.assertLess(np.abs(forces[0]).max(), 0.5)
        self.assertLess(np.abs(forces).max(), 1.0)
        self.assertGreater(min(y), -2e-4)
        self.assertAlmostEqual(y[-1], 0.0, delta=1e-5)

    def test_what_is_not_for_the_bench_is_refused(self):
        whole = random_policy(replace(full_task(), max_steps=2))
        with self.assertRaisesRegex(PolicyError, "3 rings"):
            MakePolicyControl(whole, self.brace, DEFAULT)
        three = load_policy_scenario(whole)
        with self.assertRaisesRegex(PolicyError, "for 1 rings; allowed .* 3"):
            MakePolicyControl(self.policy, three, DEFAULT)
        aslant = np.array([0.001, -0.01, 0, 0, 0, 0])
        with self.assertRaisesRegex(PolicyError, "--motion"):
            motion_of_task(replace(TASK, displacement=aslant))

    def test_a_device_of_another_geometry_is_refused(self):
        other = load_policy_scenario(self.policy)
        other.joints.stage2.upper.radius = 0.182
        with emulated(scenario=bench_of(self.brace)) as device:
            with self.assertRaisesRegex(LinkError, r"geometry.*upper\["):
                OpenDevice(device.terminal.path, other, PATIENT)


class TestLimiter(unittest.TestCase):
    def test_bounds_and_rate_hold_and_no_number_changes_nothing(self):
        limits = DEFAULT._replace(stiffness=9000.0, stiffness_rate=1e5)
        system = StiffnessLimiter(limits, 6, 1e-3)
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        asked, passed = np.zeros(6), []
        for i, value in enumerate((5000.0, 5050.0, 8000.0, np.nan, 1e9, 0.0)):
            asked[1] = value
            system.get_input_port().FixValue(context, asked)
            simulator.AdvanceTo(max(0.0, 1e-3 * i - 1e-10))
            passed.append(system.get_output_port().Eval(context)[1])
        expected = [5000.0, 5050.0, 5150.0, 5150.0, 5250.0, 5150.0]
        np.testing.assert_allclose(passed, expected)


class TestDeploy(unittest.TestCase):
    def deploy(self, folder, device, *more):
        limits = Path(folder) / "limits.yaml"
        wide = "".join(f"{name}: {value}\n" for name, value in WIDE.items())
        limits.write_text(PATIENT_LIMITS + wide)
        # A machine that tests share is late at times, which a dry run tells.
        late = mock.patch("brace_drake.link.operation.deploy.check_dry_run")
        with late as checked:
            done = run_command(
                "deploy", "--port", device.terminal.path, "--limits", limits,
                "--countdown", 0, *more,
            )  # fmt: skip
        return *done, checked

    def test_through_the_port_it_tracks_as_the_simulation_does(self):
        policy = random_policy(TASK)
        bench = bench_of(load_policy_scenario(policy))
        # A policy drawn at random makes much of noise.
        make = "tests.emulated_devices.BenchPlant"
        exact = partial(BenchPlant, seed=None)
        with (
            mock.patch(make, exact),
            emulated(scenario=bench) as device,
            tempfile.TemporaryDirectory() as folder,
        ):
            file, out = Path(folder) / "policy.npz", Path(folder) / "out"
            SavePolicy(policy, file)
            status, said, errors, checked = self.deploy(
                folder, device, "--policy", str(file), "--out", str(out)
            )
            self.assertEqual(status, 0, errors)
            self.assertIn("stiffness: 500 to 50000 N/m by the policy", said)
            self.assertIn("armed:", said)
            checked.assert_called_once()
            with open(out / "ticks.csv", newline="") as text:
                rows = list(csv.DictReader(text))
        self.assertGreater(len(rows), TICKS)
        y, y_d, K = (
            np.array([float(row[f"ring2_y{name}"]) for row in rows[:TICKS]])
            for name in ("_m", "_desired_m", "_stiffness_N_m")
        )
        y_simulated, _ = simulate(policy)
        expected = rms(y_d - y_simulated)
        self.assertAlmostEqual(rms(y_d - y) / expected, 1.0, delta=0.05)
        # Not by chance: the stiffness varies, and matters.
        self.assertGreater(np.ptp(K), 20000.0)
        self.assertGreater(expected, 1e-4)
        self.assertLess(rms(y - y_simulated), 0.05 * expected)

    def test_a_file_that_is_no_policy_has_one_line(self):
        with emulated() as device, tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "policy.npz"
            file.write_bytes(b"nothing")
            status, _, errors, _ = self.deploy(
                folder, device, "--policy", str(file)
            )
            self.assertEqual(status, 2)
            self.assertEqual(errors.count("\n"), 1)
            self.assertIn("policy.npz", errors)
            self.assertEqual(device.firmware.accepted, 0)


if __name__ == "__main__":
    unittest.main()

"""Policies on numpy: files, ONNX, and in the diagram at run time."""

import copy
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource

from brace_drake.core.errors import PolicyError
from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.deployment import PolicySystem
from brace_drake.learning.diagram_loop import MakeCubic
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.episode import run_episode
from brace_drake.learning.policy import ExportOnnx, LoadPolicy, SavePolicy
from brace_drake.learning.predict import predict_impedance
from brace_drake.learning.subjects import EffectRange
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.brace_numbers import pack_rings
from tests.learning_tasks import random_policy, short_task


def observations(policy, count=50):
    rng = np.random.default_rng(2)
    return rng.normal(size=(count, len(policy.mean))) * 5e-3


class TestFiles(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.path = folder / "policy.npz"

    def test_a_policy_comes_back_as_it_was(self):
        policy = random_policy(short_task(7, sample_time=0.02))
        SavePolicy(policy, self.path)
        back = LoadPolicy(self.path)
        for o in observations(policy):
            np.testing.assert_array_equal(policy.act(o), back.act(o))
        self.assertEqual(
            (back.task.max_steps, back.task.sample_time), (7, 0.02)
        )
        np.testing.assert_array_equal(
            back.task.limits.upper, policy.task.limits.upper
        )
        self.assertEqual(back.law.largest, policy.law.largest)

    def test_what_is_no_policy_is_refused(self):
        self.path.write_bytes(b"nothing")
        with self.assertRaisesRegex(PolicyError, "policy.npz: is not a policy"):
            LoadPolicy(self.path)
        with self.assertRaisesRegex(PolicyError, "none: .*: No such file"):
            LoadPolicy(self.path.parent / "none")
        np.savez(self.path, a=np.zeros(3))
        with self.assertRaisesRegex(PolicyError, "format"):
            LoadPolicy(self.path)
        policy = random_policy()
        short = (policy.weights[0][:, :-1], *policy.weights[1:])
        SavePolicy(replace(policy, weights=short), self.path)
        with self.assertRaisesRegex(PolicyError, "layer 0"):
            LoadPolicy(self.path)

    def test_every_field_of_the_task_within_is_checked(self):
        task = short_task()
        wrong = {
            "observation": "ring", "sample_time": -1.0, "max_steps": 10**9,
            "displacement": np.full(6, 100.0), "motion_time": 0.0,
            "readings": "loud", "failure_reward": np.nan, "backend": "none",
            "scenario": "/etc/passwd", "action.rate": 0.0,
            "action.scale": "square", "reward.kind": "none",
            "reward.position_weight": np.full(6, np.inf),
            "reward.force_scale": np.full(6, -1.0),
            "reward.force_limit": np.zeros(6), "reward.barrier_share": 1.0,
            "reward.smoothness_weight": -1.0, "limits.upper": np.ones(5),
            "limits.lower": np.full(6, 1.0), "limits.speed": np.zeros(6),
            "limits.force": np.full(6, np.nan),
            "subjects.preload": np.array([2.0, 1.0]),
            "subjects.torso_mass": np.array([1.0, 1e30]),
            "subjects.effects": [EffectRange("nothing")],
            "subjects.effects[0].probability": [EffectRange("gain", "", 2.0)],
        }  # fmt: skip
        for key, value in wrong.items():
            bad = copy.deepcopy(task)
            *holders, name = key.replace("[0].probability", "").split(".")
            setattr(getattr(bad, *holders) if holders else bad, name, value)
            SavePolicy(replace(random_policy(task), task=bad), self.path)
            with self.subTest(key), self.assertRaises(PolicyError) as caught:
                LoadPolicy(self.path)
            message = str(caught.exception)
            self.assertTrue(message.startswith(f"{self.path}: task: "))
            self.assertNotIn("\n", message)
            self.assertIn(key, message)

    def test_onnx_says_the_same(self):
        try:
            from onnx.reference import ReferenceEvaluator
        except ImportError:
            self.skipTest("onnx is not installed")
        policy, path = random_policy(), self.path.with_suffix(".onnx")
        ExportOnnx(policy, path)
        rows = observations(policy)
        (out,) = ReferenceEvaluator(str(path)).run(None, {"observation": rows})
        expected = [policy.act(o) for o in rows]
        np.testing.assert_allclose(out, expected, rtol=0, atol=1e-6)


def deployed(env, policy):
    """The nominal brace of an env as a diagram with a policy in it."""
    scenario, task = env.scenario, env.task
    controller = MakeController(scenario.control, pack_rings(scenario))
    station = MakeBraceStation(scenario, controller)
    start = station.numbers.start
    motion = MakeCubic(start, task.displacement, task.motion_time)
    builder = DiagramBuilder()
    inner = builder.AddSystem(station.diagram)
    source = builder.AddSystem(TrajectorySource(motion)).get_output_port()
    system = builder.AddSystem(PolicySystem(policy))
    for out, port in (
        (source, inner.GetInputPort("desired")),
        (source, system.GetInputPort("desired")),
        (inner.GetOutputPort("estimate"), system.GetInputPort("estimate")),
        (system.GetOutputPort("stiffness"), inner.GetInputPort("stiffness")),
    ):
        builder.Connect(out, port)
    return builder.Build(), station, system


class TestRunTime(unittest.TestCase):
    def test_the_diagram_with_a_policy_is_the_env_with_it(self):
        task = short_task(8)
        policy = random_policy(task)
        env = RlpicEnv(task)
        log = run_episode(env, policy.act)
        self.assertGreater(np.ptp(log.stiffness), 1000.0)
        diagram, station, system = deployed(env, policy)
        simulator = Simulator(diagram)
        root = simulator.get_context()
        context = station.diagram.GetMyContextFromRoot(root)
        for k, stiffness in enumerate(log.stiffness):
            simulator.AdvanceTo((k + 1) * task.sample_time - 5e-11)
            state = station.diagram.GetOutputPort("plant_state").Eval(context)
            y = state[4:7] - station.numbers.rest[0]
            expected = log.signals.position[k, 0:3]
            np.testing.assert_allclose(y, expected, rtol=1e-7, atol=1e-8)
            used = station.diagram.GetOutputPort("impedance").Eval(context)
            np.testing.assert_allclose(used[13], stiffness[0], rtol=1e-6)
        # A decision at this time has been taken, and acts from the next tick.
        asked = system.GetOutputPort("stiffness")
        asked = asked.Eval(system.GetMyContextFromRoot(root))
        self.assertTrue(np.delete(asked, 1).max() == 0.0 < asked[1])

    def test_rate_and_bounds_hold_outside_of_the_network(self):
        policy = random_policy()
        huge = tuple(1e6 * W for W in policy.weights)
        law = ActionLaw(1000.0, 9000.0, np.array([5000.0]), "linear", 0.1)
        system = PolicySystem(replace(policy, weights=huge, law=law))
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        seen = [5000.0]
        rng = np.random.default_rng(0)
        for k in range(60):
            for name in ("estimate", "desired"):
                port = system.GetInputPort(name)
                port.FixValue(context, rng.normal(size=18))
            simulator.AdvanceTo((k + 1) * 0.05 - 1e-9)
            stiffness = system.GetOutputPort("stiffness").Eval(context)
            seen.append(stiffness[1])
            np.testing.assert_array_equal(stiffness[[0, 2, 3, 4, 5]], 0.0)
        # 0.1 of a range of 2 actions is 400 N/m.
        steps = np.abs(np.diff(seen))
        self.assertLessEqual(steps.max(), 400.0 + 1e-9)
        self.assertGreater(steps.max(), 399.0)
        self.assertTrue(1000.0 <= min(seen) and max(seen) <= 9000.0)


class TestPrediction(unittest.TestCase):
    def test_impedance_follows_from_the_stiffness_of_the_motion(self):
        policy = random_policy(short_task(10))
        found = predict_impedance(policy, [0, -0.02, 0, 0, 0, 0])
        K = found.log.stiffness[5:, 0]
        self.assertEqual(found.names, ("ring2 y",))
        self.assertAlmostEqual(found.stiffness[0], K.mean())
        self.assertAlmostEqual(found.damping[0], 2 * (2 * K.mean()) ** 0.5)
        end = found.log.signals.desired[-1, 1]
        s = 0.5 / 12.0
        self.assertAlmostEqual(end, -0.02 * s * s * (3 - 2 * s))

    def test_a_subject_matters_and_must_be_one(self):
        policy = random_policy(short_task(10))
        soft, stiff = (
            predict_impedance(policy, factors={"posture_stiffness": f})
            for f in (0.5, 20.0)
        )
        self.assertGreater(stiff.force[0], soft.force[0])
        for factors in ({"colour": 1.0}, {"torso_mass": -1.0}):
            with self.assertRaisesRegex(PolicyError, "torso_mass"):
                predict_impedance(policy, factors=factors)


class TestImports(unittest.TestCase):
    def test_nothing_but_training_needs_torch_or_stable_baselines(self):
        code = (
            "import sys\n"
            "class Absent:\n"
            "    def find_spec(self, name, path=None, target=None):\n"
            "        if name in ('torch', 'stable_baselines3', 'onnx'):\n"
            "            raise ModuleNotFoundError(name, name=name)\n"
            "sys.meta_path.insert(0, Absent())\n"
            "import brace_drake.learning.predict\n"
            "import brace_drake.learning.deployment\n"
            "from brace_drake.cli.main import main\n"
            "sys.exit(main(['train', '--out', 'nowhere']))\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("pip install -e '.[train]'", done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()

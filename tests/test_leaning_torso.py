"""A torso that leans on a pad: by one equation, at rest, and by the diagram."""

import unittest
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from brace_drake.core.resources import policy_path, scenario_path
from brace_drake.experiments.paper_torso import reach
from brace_drake.experiments.paper_torso.lean import (
    LEANING,
    Lean,
    leaning_task,
    run_push,
)
from brace_drake.experiments.paper_torso.pushes import whole_brace
from brace_drake.experiments.rollouts import Benchmark, Controller
from brace_drake.experiments.tables import TABLE_1_PIC, TABLE_1_RLPIC
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.ticks import run_ticks
from brace_drake.laws.plug_in import make_effects
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.policy import LoadPolicy
from brace_drake.learning.subjects import NOMINAL
from brace_drake.learning.task import load_task_scenario
from brace_drake.scenario.brace_numbers import pack_brace
from brace_drake.scenario.load import LoadScenario

M_D, K_D, KP, KV, RING, TORSO = 2.0, 6000.0, 6500.0, 1000.0, 0.85, 40.0
K, C, TAU, PUSH = 6400.0, 150.0, 0.02, 1.9
C_D = 2.0 * np.sqrt(M_D * K_D)


def one_coordinate(load, seconds):
    """(4) to (6) along y in continuous time: y, y', force on the torso.

    The torso leans by PUSH along -y, on the pad that goes ahead of it.
    """

    def rates(t, s):
        y, v, torso, u, y_v, v_v, filtered = s
        x = min(t / 12.0, 1.0)
        y_d = -0.01 * (3 * x**2 - 2 * x**3)
        v_d = -0.01 / 12 * 6 * (x - x**2)
        a_d = -0.01 / 144 * (6 - 12 * x)
        depth, rate = y - torso, v - u
        force = max(0.0, K * depth + C * rate) if depth > 0.0 else 0.0
        a_v = a_d + (C_D * (v_d - v_v) + K_D * (y_d - y_v) - filtered) / M_D
        drive = RING * (a_v + KV * (v_v - v) + KP * (y_v - y)) + filtered
        return [
            v, (drive - force) / RING,
            u, (force - PUSH) / TORSO, v_v, a_v, (force - filtered) / TAU,
        ]  # fmt: skip

    start = [0.0, 0.0, -load / K, 0.0, 0.0, 0.0, 0.0]
    times = np.arange(0.005, seconds + 1e-9, 0.005)
    found = solve_ivp(
        rates, (0, seconds), start, t_eval=times, rtol=1e-8, atol=1e-11,
        method="LSODA",
    )  # fmt: skip
    y, v, torso, u = found.y[:4]
    return y, v, np.maximum(K * (y - torso) + C * (v - u), 0.0)


class TestLean(unittest.TestCase):
    def scenario(self, **lean):
        numbers = {"push": PUSH, "load": PUSH, "across": 0.0, **lean}
        return Lean(**numbers).apply(load_task_scenario(leaning_task()))

    def test_a_push_is_that_of_one_coordinate(self):
        scenario = self.scenario(load=1.2)
        scenario.leg.viscous = 0.0
        task = replace(leaning_task(), max_steps=60)
        rollout = Benchmark(task, scenario).run(Controller("pic"), NOMINAL)
        y, v, force = one_coordinate(1.2, 3.0)
        ours = rollout.signals
        # The loop is sampled at 1 kHz, the equation is not.
        np.testing.assert_allclose(ours.position[:, 1], y, atol=6e-6)
        np.testing.assert_allclose(ours.rate[20:, 1], v[20:], atol=6e-5)
        np.testing.assert_allclose(-ours.force[20:, 1], force[20:], atol=0.02)
        self.assertGreater(np.abs(v).max(), 1.5e-3)

    def test_a_torso_in_balance_with_its_pad_stays_where_it_is(self):
        numbers = pack_brace(self.scenario())
        # Rings without forces do not move: weight off, legs without command.
        numbers.ring[:, 4] = 0.0
        numbers.ring[:, :4] *= 1e9
        brace = make_brace(numbers, with_torso=True)
        start = brace.poses[1].copy()
        self.assertAlmostEqual(start[5], -PUSH / K, delta=1e-15)
        plant = run_ticks(
            5e-4, 2, numbers, make_effects({}, 1), brace, np.full(12, np.nan)
        )
        for _ in range(500):
            next(plant)
        np.testing.assert_allclose(brace.poses[1], start, atol=1e-9)
        np.testing.assert_allclose(brace.f_T[0], [0, PUSH, 0], atol=1e-6)

    def test_without_a_pad_the_lean_moves_the_torso_as_a_free_mass(self):
        scenario = self.scenario(across=0.5)
        scenario.contact.ring2.model = "none"
        numbers = pack_brace(scenario)
        brace = make_brace(numbers, with_torso=True)
        plant = run_ticks(
            5e-4, 2, numbers, make_effects({}, 1), brace, np.full(12, np.nan)
        )
        for _ in range(101):
            next(plant)
        expected = np.array([0.5, -PUSH, 0.5]) / TORSO * 0.1
        np.testing.assert_allclose(brace.V[1, 3:6], expected, rtol=1e-9)

    def test_diagram_and_compiled_laws_agree(self):
        rows = {}
        for backend in ("compiled", "diagram"):
            env = RlpicEnv(
                replace(leaning_task(), max_steps=12, backend=backend)
            )
            env.reset(seed=1)
            found = []
            for action in np.linspace(-0.9, 0.9, 12):
                found.append(env.step(np.array([action]))[0])
                found.append(np.concatenate(env.loop.truth()))
            rows[backend] = found
        for a, b in zip(*rows.values(), strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-8, atol=1e-8)
        # It leans, and across the push too.
        force = np.abs(rows["compiled"][-1][-6:-3])
        self.assertGreater(force.min(), 0.05)

    def test_no_lean_is_the_default(self):
        plain = LoadScenario(scenario_path("paper_pic.scenario.yaml"))
        np.testing.assert_array_equal(plain.torso.lean, np.zeros(3))
        np.testing.assert_array_equal(plain.start.torso, np.zeros(6))


class TestTable1(unittest.TestCase):
    def test_pic_meets_four_entries_with_the_numbers_of_the_scenario(self):
        scenario = load_task_scenario(leaning_task())
        _, score = run_push(
            Benchmark(leaning_task(), scenario), Controller("pic")
        )
        for name in ("y_rms", "x_rms", "z_rms", "force_rms"):
            with self.subTest(entry=name):
                ratio = getattr(score, name) / getattr(TABLE_1_PIC, name)
                self.assertAlmostEqual(ratio, 1.0, delta=0.25)

    def test_rlpic_trained_there_comes_to_the_papers_stiffness(self):
        policy = LoadPolicy(policy_path("rlpic_leaning.npz"))
        bench = Benchmark(leaning_task(), load_task_scenario(leaning_task()))
        _, score = run_push(bench, Controller("rlpic", policy=policy))
        self.assertAlmostEqual(score.stiffness / 49990.0, 1.0, delta=0.1)
        self.assertLessEqual(score.y_rms, TABLE_1_RLPIC.y_rms)
        self.assertLessEqual(score.vy_rms, TABLE_1_RLPIC.vy_rms)

    def test_the_whole_brace_is_pushed_at_its_second_ring_alone(self):
        scenario = whole_brace(LoadScenario(scenario_path(LEANING)))
        self.assertEqual(scenario.stages, [1, 2, 3])
        linear = [c.model == "linear" for c in scenario.contacts]
        self.assertEqual(linear, [False, True, False])


class TestReach(unittest.TestCase):
    def test_velocity_over_force_is_that_of_a_mass_behind_a_pad(self):
        # Slow: the mass alone; fast: the damper alone.
        law = 40.0, 6400.0, 150.0
        slow, fast = reach.rate_per_force(np.array([0.01, 1e6]), *law)
        self.assertAlmostEqual(slow * 0.01 * 40.0, 1.0, delta=1e-4)
        self.assertAlmostEqual(fast * 150.0, 1.0, delta=1e-4)

    def test_a_row_is_reached_at_the_ends_of_its_band(self):
        law = 40.0, 6400.0, 150.0
        ends = np.array(reach.frequencies_of(TABLE_1_PIC, *law))
        ratio = TABLE_1_PIC.vy_rms / TABLE_1_PIC.force_rms
        np.testing.assert_allclose(
            reach.rate_per_force(ends, *law), ratio, rtol=1e-3
        )

    def test_the_inertial_force_is_that_of_the_cubic(self):
        t = np.linspace(0, 1, 100_001)
        force = 40.0 * -0.01 / 144 * (6 - 12 * t)
        rms = np.sqrt(np.trapezoid((force - force[-1]) ** 2, t))
        ours = reach.inertial_force_rms(40.0, -0.01, 12.0)
        self.assertAlmostEqual(ours, rms, places=8)


if __name__ == "__main__":
    unittest.main()

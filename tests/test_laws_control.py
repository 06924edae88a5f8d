"""Filters, impedance (4), (5) and inverse dynamics (6)."""

import math
import unittest

import numpy as np

from brace_drake.laws.control import brace_control, pose_estimate
from brace_drake.laws.control import impedance as control
from brace_drake.laws.linear_solve import solve_in_place
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench

M_D, K_D = 2.0, 6000.0
C_D = 2.0 * math.sqrt(M_D * K_D)
H = 1e-3


class TestImpedance(unittest.TestCase):
    def settle(self, force, seconds=1.0, desired=(-0.01, 0.0, 0.0)):
        virtual = np.zeros(3)
        for _ in range(round(seconds / H)):
            control.update_impedance(
                M_D, C_D, K_D, np.array(desired), force, H, virtual
            )
        return virtual

    def test_at_rest_the_error_is_force_over_stiffness(self):
        for force in (0.0, -1.9, 6.0):
            virtual = self.settle(force)
            self.assertAlmostEqual(virtual[0], -0.01 - force / K_D, places=12)
            self.assertAlmostEqual(virtual[1], 0.0, places=10)

    def test_a_step_of_force_follows_the_critically_damped_solution(self):
        force, t, w = 3.0, 0.05, math.sqrt(K_D / M_D)
        exact = -force / K_D * (1 - (1 + w * t) * math.exp(-w * t))
        virtual = self.settle(force, t, (0, 0, 0))
        # First order in h: h / 2 times the speed, 1.1e-5 m at most.
        self.assertAlmostEqual(virtual[0], exact, delta=1.2e-5)

    def test_a_perfect_start_follows_the_reference_without_force(self):
        virtual = np.array([0.0, 0.01, 0.0])
        for k in range(1000):
            desired = np.array([0.01 * k * H, 0.01, 0.0])
            control.update_impedance(M_D, C_D, K_D, desired, 0.0, H, virtual)
        self.assertAlmostEqual(virtual[0], 0.01, places=12)

    def test_the_force_goes_through_a_first_order_low_pass(self):
        gain, filtered = control.low_pass_gain_tau(0.02, H), np.zeros(6)
        for _ in range(20):
            brace_control.filter_force(np.ones(3), gain, filtered)
        passed = 1.0 - math.exp(-1.0)
        expected = [passed, passed, passed, 0.0, 0.0, 0.0]
        np.testing.assert_allclose(filtered, expected, rtol=1e-12)


class TestFilters(unittest.TestCase):
    def test_gain_of_a_cutoff_is_that_of_its_time_constant(self):
        self.assertAlmostEqual(
            control.low_pass_gain_cutoff(40.0, H),
            control.low_pass_gain_tau(1 / (2 * math.pi * 40.0), H),
            places=15,
        )

    def test_velocity_estimate_of_a_ramp_becomes_its_slope(self):
        X, previous, V = np.zeros(6), np.zeros(6), np.zeros(6)
        for k in range(200):
            X[:] = 0.3 * k * H
            control.update_velocity_estimate(X, previous, V, 0.2, H)
        np.testing.assert_allclose(V, 0.3, rtol=1e-12)


class TestTick(unittest.TestCase):
    """A first tick: no velocity yet, and a force that is filtered."""

    def setUp(self):
        self.numbers = pack_bench(BenchScenario())

    def commands(self, p=(0.0, 0.0, 0.0), force=0.0, desired=(0.0, 0.0, 0.0)):
        """Leg commands with the ring at p, and the directions of the legs."""
        numbers = self.numbers
        d = numbers.upper[0] + numbers.rest + p - numbers.lower[0]
        lengths = np.linalg.norm(d, axis=1)
        readings = np.array([*lengths, 0.0, force, 0.0, *np.zeros(3)])
        u, X_d = np.empty(6), np.zeros((3, 6))
        X_d[:, 1] = desired
        memory = np.zeros((1, 6))
        held = brace_control.start_held(numbers.start, numbers.rest, memory)
        result = brace_control.advance_brace(
            brace_control.PIC, numbers.control, held, readings, X_d.ravel(),
            np.empty(0), u,
        )  # fmt: skip
        self.assertEqual(result, brace_control.GOOD)
        return u, d / lengths[:, None]

    def test_at_rest_the_legs_carry_the_weight(self):
        u, n = self.commands()
        np.testing.assert_allclose(u @ n, [0, 0, 0.85 * 9.81], atol=1e-12)

    def test_the_task_force_is_equation_six(self):
        p, force, desired = (0.001, 0.002, 0.003), -3.0, (0.004, 0.05, 0.6)
        u, n = self.commands(p, force, desired)
        passed = force * (1.0 - math.exp(-H / 0.02))
        virtual = np.zeros(3)
        control.update_impedance(
            M_D, C_D, K_D, np.array(desired), passed, H, virtual
        )
        y, y_d, y_dd = virtual
        F = -0.85 * 1600.0 * np.array(p)
        F[1] += 0.85 * (y_dd + 80.0 * y_d + 1600.0 * y) + passed
        F[2] += 0.85 * 9.81
        np.testing.assert_allclose(u @ n, F, rtol=0, atol=1e-9)

    def test_commands_stop_at_the_limit(self):
        u, _ = self.commands(desired=(-1e5, 0.0, 0.0))
        self.assertEqual(np.abs(u).max(), 120.0)

    def test_the_pose_of_the_first_tick_gives_no_velocity(self):
        numbers, memory = self.numbers, np.zeros(20)
        memory[0:3], memory[3] = numbers.rest[0], 1.0
        p = numbers.rest[0] + np.array([0, 0.001, 0])
        d = numbers.upper[0] + p - numbers.lower[0]
        lengths = np.linalg.norm(d, axis=1)
        estimate = np.empty(19)
        good = pose_estimate.estimate_pose(
            lengths,
            numbers.control[brace_control.ESTIMATOR],
            numbers.lower[0],
            numbers.upper[0],
            memory,
            estimate,
            (np.empty((3, 3)), np.empty((6, 6)), np.empty(6), np.empty(6)),
        )
        self.assertTrue(good)
        np.testing.assert_allclose(
            estimate[0:12], [0, 0.001, *[0] * 10], atol=1e-12
        )


class TestSolve(unittest.TestCase):
    def test_it_solves_what_numpy_solves(self):
        generator = np.random.default_rng(2)
        A, b = generator.normal(size=(6, 6)), generator.normal(size=6)
        A[0, 0] = 0.0  # a pivot is needed
        x = b.copy()
        self.assertTrue(solve_in_place(A.copy(), x))
        np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-10)

    def test_a_singular_matrix_is_told(self):
        self.assertFalse(solve_in_place(np.ones((6, 6)), np.ones(6)))


if __name__ == "__main__":
    unittest.main()

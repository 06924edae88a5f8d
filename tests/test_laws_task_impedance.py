"""IDC and PIC on all task coordinates, equations (4) to (6)."""

import math
import unittest

import numpy as np

from brace_drake.laws.control import task_impedance

H = 1e-3
M_D, K_D = 2.0, 6000.0


class Filter:
    """Equation (5) on six coordinates, of which y and z have an impedance."""

    def __init__(self, ratio=1.0, period=H):
        self.selected = np.array([0.0, 1, 1, 0, 0, 0])
        self.M, self.K = np.full(6, M_D), np.full(6, K_D)
        self.K[2] = 1500.0
        self.C = 2 * ratio * np.sqrt(self.M * self.K)
        self.period = period
        self.virtual, self.used = np.zeros((3, 6)), np.ones((3, 6))
        self.desired, self.force = np.zeros((3, 6)), np.zeros(6)

    def step(self):
        task_impedance.advance_pic(
            self.desired, self.force, self.period, self.selected,
            self.M, self.C, self.K, self.virtual, self.used,
        )  # fmt: skip
        return self.virtual


class TestPic(unittest.TestCase):
    def test_at_rest_the_error_is_force_over_stiffness(self):
        dut = Filter()
        dut.desired[0] = 0.01 * np.arange(6)
        dut.force[:] = [1.0, -3.0, 2.0, 0.1, 0.1, 0.1]
        for _ in range(2000):
            dut.step()
        e = dut.desired[0] - dut.virtual[0]
        expected = [0, -3.0 / K_D, 2.0 / 1500.0, 0, 0, 0]
        np.testing.assert_allclose(e, expected, atol=1e-15)

    def test_coordinates_without_impedance_follow_their_reference(self):
        dut = Filter()
        dut.desired[:] = np.random.default_rng(1).normal(size=(3, 6))
        dut.step()
        for i in (0, 3, 4, 5):
            np.testing.assert_array_equal(dut.virtual[:, i], dut.desired[:, i])
            np.testing.assert_array_equal(dut.used[:, i], 0.0)
        np.testing.assert_array_equal(dut.used[:, 1], [M_D, dut.C[1], K_D])

    def test_a_step_of_force_follows_the_exact_second_order_solution(self):
        force, ratio, end = 3.0, 0.4, 0.06
        w, errors = math.sqrt(K_D / M_D), []
        damped, decay = w * math.sqrt(1 - ratio**2), ratio * w
        wave = math.cos(damped * end) + decay / damped * math.sin(damped * end)
        exact = -force / K_D * (1.0 - math.exp(-decay * end) * wave)
        for period in (1e-4, 5e-5):
            dut = Filter(ratio, period)
            dut.force[1] = force
            for _ in range(round(end / period)):
                dut.step()
            errors.append(abs(dut.virtual[0, 1] - exact))
        self.assertLess(errors[0], 2e-3 * abs(exact))
        # First order in the period.
        self.assertAlmostEqual(errors[0] / errors[1], 2.0, delta=0.1)

    def test_no_more_energy_comes_out_than_force_has_put_in(self):
        dut = Filter(ratio=0.1, period=1e-5)
        generator = np.random.default_rng(3)
        work, least, before = 0.0, 0.0, 0.0
        for k in range(20000):
            if k % 200 == 0:
                dut.force[1] = generator.normal()
            dut.step()
            e, e_d = -dut.virtual[0, 1], -dut.virtual[1, 1]
            work += dut.force[1] * (e - before)
            before = e
            stored = 0.5 * (M_D * e_d**2 + K_D * e**2)
            least = min(least, work - stored)
        self.assertGreater(work, 1e-5)
        # Rounding of the rule is of first order in the period.
        self.assertGreater(least, -0.01 * work)


class TestIdc(unittest.TestCase):
    def test_an_error_obeys_the_second_order_law_of_the_gains(self):
        kp, kd, mass, period = 1600.0, 60.0, 0.85, 1e-5
        X, V, F = 0.003, 0.0, np.empty(6)
        gains = np.array([np.full(6, kp), np.full(6, kd)])
        virtual, used = np.empty((3, 6)), np.empty((3, 6))
        task_impedance.advance_idc(np.zeros((3, 6)), virtual, used)
        end = 0.05
        for _ in range(round(end / period)):
            state = np.zeros((2, 6))
            state[:, 1] = X, V
            task_impedance.calc_task_forces(
                state, virtual, np.full(6, 5.0), np.ones(6), gains,
                np.full(6, mass), np.zeros(6), F,
            )  # fmt: skip
            # 5 N of interaction pull back on the ring.
            V += period * (F[1] - 5.0) / mass
            X += period * V
        damped, decay = math.sqrt(kp - kd**2 / 4), kd / 2
        wave = math.cos(damped * end) + decay / damped * math.sin(damped * end)
        exact = 0.003 * math.exp(-decay * end) * wave
        self.assertAlmostEqual(X, exact, delta=2e-6)
        np.testing.assert_array_equal(used, 0.0)

    def test_a_force_that_is_not_known_leaves_it_over_m_and_kp(self):
        F, virtual = np.empty(6), np.zeros((3, 6))
        state = np.zeros((2, 6))
        state[0, 1] = -2.0 / (0.85 * 1600.0)
        gains = np.array([np.full(6, 1600.0), np.full(6, 80.0)])
        weight = np.array([0, 0, 8.3, 0, 0, 0])
        task_impedance.calc_task_forces(
            state, virtual, np.full(6, 9.0), np.zeros(6), gains,
            np.full(6, 0.85), weight, F,
        )  # fmt: skip
        np.testing.assert_allclose(F, [0, 2, 8.3, 0, 0, 0], atol=1e-12)


if __name__ == "__main__":
    unittest.main()

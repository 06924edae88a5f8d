"""Laws that learn the impedance: MRAIC and NPIC."""

import math
import unittest

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from brace_drake.laws.control import mraic, npic
from brace_drake.laws.control.regressor import step_regressor

H = 1e-3
M, K = 2.0, 6000.0
C = 2.0 * math.sqrt(M * K)
WANTED = np.array([[M], [C], [K]])
ONE = np.ones(1)


def rich_force(t):
    """Four tones around the impedance's natural frequency, N."""
    tones = (3.0, 11.0, 37.0, 71.0)
    return sum(3.0 * math.sin(w * t + i) for i, w in enumerate(tones))


def mraic_law(rates=(3.0, 3.0, 3.0), leak=0.0, filter_hz=5.0):
    """Rows for one coordinate, scaled as a scenario's numbers are."""
    law, scale = np.zeros((mraic.NUM_MRAIC_LAW, 1)), 5e-4
    theta = WANTED[:, 0]
    law[0:3, 0] = np.array(rates) * theta**2 * M / (K * scale**2)
    law[3:6, 0], law[6:9, 0] = 0.3 * theta, 3.0 * theta
    law[9:11, 0] = mraic.lyapunov_gains(M, C, K, 2 * K / M, 2.0)
    law[11], law[12] = leak, 2 * math.pi * filter_hz
    return law


class TestMraicLaw(unittest.TestCase):
    def test_the_gains_solve_the_lyapunov_equation(self):
        Q, A = np.diag([7.0, 0.3]), np.array([[0, 1], [-K / M, -C / M]])
        P = solve_continuous_lyapunov(A.T, -Q)
        gains = mraic.lyapunov_gains(M, C, K, *np.diag(Q))
        np.testing.assert_allclose(gains, P[1] / M, rtol=1e-12)

    def follow(self, sign, seconds):
        """V along a run on the reference plant with an unknown impedance."""
        period = 5e-5
        law = mraic_law()
        law[0:3] *= sign
        Q, A = np.diag([2 * K / M, 2.0]), np.array([[0, 1], [-K / M, -C / M]])
        P = solve_continuous_lyapunov(A.T, -Q)
        hidden = np.array([0.2 * M, -0.3 * C, 0.4 * K])
        theta, model = WANTED.copy(), np.zeros(2)
        e, e_d, values = 0.0, 0.0, []
        for k in range(round(seconds / period)):
            force = rich_force(k * period)
            shown = theta[:, 0] + hidden
            e_dd = (force - shown[1] * e_d - shown[2] * e) / shown[0]
            z = np.array([e - model[0], e_d - model[1]])
            off = shown - WANTED[:, 0]
            values.append(z @ P @ z + np.sum(off**2 / law[0:3, 0]) * sign)
            s = law[9, 0] * z[0] + law[10, 0] * z[1]
            mraic.adapt_impedance(
                0, (e_dd, e_d, e), s, period, WANTED, law, theta
            )
            mraic.step_reference(M, C, K, force, period, model)
            e_d += period * e_dd
            e += period * e_d
        return np.array(values), off / WANTED[:, 0]

    def test_the_lyapunov_function_does_not_grow(self):
        V, off = self.follow(1.0, 6.0)
        growth = np.max(V - np.minimum.accumulate(V))
        # What stepping adds is of first order in the period.
        self.assertLess(growth, 2e-3 * V[0])
        self.assertLess(V[-1], 0.05 * V[0])
        self.assertLess(np.abs(off).max(), 0.1)

    def test_with_the_other_sign_the_parameters_run_to_their_limits(self):
        _, off = self.follow(-1.0, 3.0)
        self.assertGreater(np.abs(off).max(), 0.6)

    def test_a_parameter_stays_between_its_limits(self):
        for phi, end in ((1.0, 3.0), (-1.0, 0.5)):
            theta = 1.0
            for _ in range(100):
                theta = mraic.adapt_parameter(
                    theta, 1.0, 0.5, 3.0, 1.0, 0.0, phi, 50.0, H
                )
            self.assertEqual(theta, end)

    def test_without_motion_the_leak_leads_back_to_the_reference(self):
        theta = 3.0
        for _ in range(5000):
            theta = mraic.adapt_parameter(
                theta, 1.0, 0.1, 9.0, 1.0, 0.4, 0.0, 1.0, H
            )
        self.assertAlmostEqual(theta, 1 + 2 * math.exp(-2.0), delta=1e-3)


class Plant:
    """A ring that shows the impedance of (5) and something unknown in it."""

    def __init__(self, hidden):
        self.hidden, self.e, self.e_d = hidden, 0.0, 0.0

    def step(self, theta, force):
        M_s, C_s, K_s = theta + self.hidden
        a = (force - C_s * self.e_d - K_s * self.e) / M_s
        self.e_d += H * a
        self.e += H * self.e_d


class TestMraic(unittest.TestCase):
    def test_the_shown_impedance_becomes_the_reference(self):
        hidden = np.array([0.0, 0.3 * C, -0.4 * K])
        law = mraic_law(rates=(0.0, 3.0, 3.0), filter_hz=15.0)
        plant = Plant(hidden)
        memory = np.zeros((mraic.NUM_MRAIC_MEMORY, 1))
        memory[6:9] = WANTED
        virtual, used = np.zeros((3, 1)), WANTED.copy()
        for k in range(40000):
            force = rich_force(k * H)
            state = np.array([[-plant.e], [-plant.e_d]])
            mraic.advance_mraic(
                np.zeros((3, 1)), state, np.array([force]), H, ONE, WANTED,
                law, memory, virtual, used,
            )  # fmt: skip
            plant.step(used[:, 0], force)
        shown = (used[:, 0] + hidden) / WANTED[:, 0]
        np.testing.assert_allclose(shown, 1.0, atol=0.02)

    def test_a_ring_that_shows_the_reference_changes_nothing(self):
        law, plant = mraic_law(), Plant(np.zeros(3))
        memory = np.zeros((mraic.NUM_MRAIC_MEMORY, 1))
        memory[6:9] = WANTED
        virtual, used = np.zeros((3, 1)), np.zeros((3, 1))
        for k in range(3000):
            state = np.array([[-plant.e], [-plant.e_d]])
            force = rich_force(k * H)
            mraic.advance_mraic(
                np.zeros((3, 1)), state, np.array([force]), H, ONE, WANTED,
                law, memory, virtual, used,
            )  # fmt: skip
            plant.step(used[:, 0], force)
        np.testing.assert_allclose(used, WANTED, rtol=1e-10)


class TestRegressor(unittest.TestCase):
    def test_the_impedance_relation_holds_behind_the_filter(self):
        plant, memory = Plant(np.zeros(3)), np.zeros(4)
        for k in range(2000):
            force = rich_force(k * H)
            phi = step_regressor(plant.e, force, 40.0, H, memory)
            self.assertAlmostEqual(
                M * phi[0] + C * phi[1] + K * phi[2], phi[3], places=10
            )
            plant.step(WANTED[:, 0], force)


def npic_law(kappa=0.5, forgetting=0.999, limit=100.0):
    law = np.zeros((npic.NUM_NPIC_LAW, 1))
    law[0:5, 0] = 2 * math.pi * 5.0, forgetting, kappa, limit, 0.2
    law[5:8], law[8:11] = 0.2, 5.0
    return law


def npic_memory():
    memory = np.zeros((npic.NUM_NPIC_MEMORY, 1))
    memory[4:10] = 1.0
    return memory


class TestNpic(unittest.TestCase):
    def run_npic(self, law, shown, force, seconds):
        """A ring whose error is shown(virtual error); its end and memory."""
        memory, virtual, used = (
            npic_memory(),
            np.zeros((3, 1)),
            np.empty((3, 1)),
        )
        e = e_d = 0.0
        for k in range(round(seconds / H)):
            npic.advance_npic(
                np.zeros((3, 1)), np.array([[-e], [-e_d]]),
                np.array([force(k * H)]), H, ONE, WANTED, law, memory,
                virtual, used,
            )  # fmt: skip
            e, e_d = shown(-virtual[0, 0]), shown(-virtual[1, 0])
        return e, memory

    def test_clean_data_give_the_known_impedance(self):
        known = np.array([1.3, 0.6, 2.1])
        plant = Plant(np.zeros(3))
        memory, theta = np.zeros(4), np.ones(3)
        P = np.array([1e6, 1e6, 1e6, 0, 0, 0])
        for k in range(4000):
            force = rich_force(k * H)
            phi = step_regressor(plant.e, force, 60.0, H, memory)
            psi = tuple(WANTED[:, 0] * phi[:3])
            npic.update_estimate(psi, phi[3], 0.999, 1e9, theta, P)
            plant.step(known * WANTED[:, 0], force)
        np.testing.assert_allclose(theta, known, rtol=1e-6)

    def test_noise_gives_an_estimate_within_its_covariance(self):
        generator, known = np.random.default_rng(5), np.array([1.0, 2.0, 0.5])
        theta, P, sigma = np.zeros(3), np.array([1e4, 1e4, 1e4, 0, 0, 0]), 0.3
        for _ in range(3000):
            psi = generator.normal(size=3)
            y = psi @ known + sigma * generator.normal()
            npic.update_estimate(tuple(psi), y, 1.0, 1e9, theta, P)
        deviation = sigma * np.sqrt(P[0:3])
        self.assertTrue(np.all(deviation < 0.01))
        self.assertTrue(np.all(np.abs(theta - known) < 4 * deviation))

    def test_at_rest_the_error_is_force_over_stiffness_for_any_kappa(self):
        for kappa in (0.0, 0.3, 0.9):
            with self.subTest(kappa=kappa):
                law = npic_law(kappa)
                e, _ = self.run_npic(law, lambda e: e, lambda t: 3.0, 20.0)
                self.assertAlmostEqual(e, 3.0 / K, delta=1e-3 * 3.0 / K)

    def test_kappa_pulls_a_soft_ring_towards_the_wanted_stiffness(self):
        soft = 1.3  # the ring gives way by this much more than it should
        for kappa in (0.0, 0.3, 0.9):
            with self.subTest(kappa=kappa):
                law = npic_law(kappa)
                e, _ = self.run_npic(
                    law, lambda e: soft * e, lambda t: 3.0, 20.0
                )
                # K e / soft = (1 + kappa) F - kappa K e where the estimate fits
                expected = (1 + kappa) / (1 / soft + kappa) * 3.0 / K
                self.assertAlmostEqual(e, expected, delta=2e-3 * expected)

    def test_nothing_is_forgotten_without_end(self):
        _, memory = self.run_npic(
            npic_law(limit=20.0), lambda e: e, lambda t: 3.0, 30.0
        )
        trace = memory[7:10].sum()
        self.assertGreater(trace, 5.0)
        self.assertLessEqual(trace, 20.0)
        self.assertTrue(np.all(memory[7:10] > 0.0))

    def test_below_its_excitation_nothing_is_estimated(self):
        _, memory = self.run_npic(
            npic_law(), lambda e: 1.4 * e, lambda t: 0.05, 2.0
        )
        np.testing.assert_array_equal(memory[4:7], 1.0)


if __name__ == "__main__":
    unittest.main()

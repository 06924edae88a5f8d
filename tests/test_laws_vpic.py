"""Variable stiffness: the limit that keeps the stored energy from growing."""

import math
import unittest

import numpy as np

from brace_drake.laws.control import vpic

H, M, LOWER, UPPER = 1e-3, 2.0, 200.0, 50000.0


def alpha_of(ratio, share=0.8):
    return share * 2.0 * ratio * math.sqrt(LOWER / M)


class Loop:
    """The filter of VPIC on one coordinate without a force."""

    def __init__(self, ratio, e=1e-3, e_d=0.0):
        self.ratio, self.alpha = ratio, alpha_of(ratio)
        self.law = np.zeros((vpic.NUM_VPIC_LAW, 1))
        self.law[0:4, 0] = LOWER, UPPER, self.alpha, ratio
        self.memory = np.full((vpic.NUM_VPIC_MEMORY, 1), LOWER)
        self.virtual = np.array([[-e], [-e_d], [0.0]])
        self.used = np.zeros((3, 1))
        self.wanted = np.array([[M], [0.0], [LOWER]])

    @property
    def error(self):
        return -self.virtual[0, 0], -self.virtual[1, 0]

    def ask(self, K):
        """One tick; the energy with which it sets out."""
        before = self.error
        good = vpic.advance_vpic(
            np.zeros((3, 1)), np.zeros((2, 1)), np.zeros(1), np.array([K]),
            H, np.ones(1), self.wanted, self.law, self.memory, self.virtual,
            self.used,
        )  # fmt: skip
        assert good
        return vpic.stored_energy(
            M, self.used[2, 0], self.ratio, self.alpha, *before
        )


def worst_request(e, e_d):
    """Stiff until the error runs at its fastest, then soft: a swing."""
    fast = math.sqrt(UPPER / M)
    coming = e * e_d <= 0.0 and abs(e_d) < 0.5 * fast * abs(e)
    return UPPER if coming else LOWER


def swing_freely(ratio, ticks):
    """The unlimited rule: errors under requests that are obeyed at once."""
    e, e_d, peaks = 1e-3, 0.0, []
    for _ in range(ticks):
        K = worst_request(e, e_d)
        C = 2 * ratio * math.sqrt(M * K)
        e_d -= H * (C * e_d + K * e) / M
        e += H * e_d
        peaks.append(abs(e))
    return np.array(peaks)


class TestCondition(unittest.TestCase):
    def test_it_becomes_that_of_kronander_and_billard(self):
        for ratio in (0.3, 1.0, 2.0):
            alpha = alpha_of(ratio)
            for K in (300.0, 6000.0, 40000.0):
                rate = 2 * alpha * K / (1 + alpha * ratio * math.sqrt(M / K))
                off = []
                for period in (1e-6, 1e-7):
                    top = vpic.highest_next_stiffness(
                        M, K, ratio, alpha, period
                    )
                    off.append((top - K) / (period * rate) - 1.0)
                with self.subTest(ratio=ratio, K=K):
                    self.assertLess(abs(off[0]), 3e-3)
                    self.assertLess(abs(off[1]), 0.15 * abs(off[0]) + 1e-5)

    def test_it_is_the_largest_stiffness_without_growth(self):
        ratio, K = 0.7, 3000.0
        alpha = alpha_of(ratio)
        top = vpic.highest_next_stiffness(M, K, ratio, alpha, H)
        C = 2 * ratio * math.sqrt(M * K)

        def worst_growth(K_next):
            growth = -np.inf
            for angle in np.linspace(0.0, math.pi, 20001):
                e, e_d = math.cos(angle), 60.0 * math.sin(angle)
                v = e_d - H * (C * e_d + K * e) / M
                before = vpic.stored_energy(M, K, ratio, alpha, e, e_d)
                after = vpic.stored_energy(
                    M, K_next, ratio, alpha, e + H * v, v
                )
                growth = max(growth, (after - before) / before)
            return growth

        self.assertLessEqual(worst_growth(top), 1e-12)
        self.assertGreater(worst_growth(top * 1.001), 0.0)


class TestEnergy(unittest.TestCase):
    def test_a_rule_without_limit_swings_itself_up(self):
        for ratio in (0.3, 1.0):
            peaks = swing_freely(ratio, 3000)
            with self.subTest(ratio=ratio):
                self.assertGreater(peaks[-500:].max(), 10.0 * 1e-3)

    def test_the_same_requests_within_the_limit_only_lose_energy(self):
        for ratio in (0.3, 1.0):
            loop = Loop(ratio)
            V = []
            for _ in range(3000):
                V.append(loop.ask(worst_request(*loop.error)))
            with self.subTest(ratio=ratio):
                self.assertLessEqual(np.diff(V).max(), 1e-12 * V[0])
                self.assertLess(V[-1], 1e-3 * V[0])

    def test_no_request_at_all_makes_energy_grow(self):
        generator = np.random.default_rng(4)
        for trial in range(40):
            ratio = generator.uniform(0.2, 1.5)
            loop = Loop(ratio, *generator.normal(size=2) * [1e-3, 0.1])
            V = []
            for _ in range(300):
                K = math.exp(generator.uniform(math.log(20), math.log(5e5)))
                V.append(loop.ask(K))
            with self.subTest(trial=trial):
                self.assertLessEqual(np.diff(V).max(), 1e-12 * V[0])


class TestRequests(unittest.TestCase):
    def test_limits_hold_and_lowering_is_free(self):
        loop = Loop(1.0)
        for _ in range(2000):
            loop.ask(1e9)
        self.assertEqual(loop.used[2, 0], UPPER)
        loop.ask(1.0)
        self.assertEqual(loop.used[2, 0], LOWER)

    def test_damping_follows_the_stiffness(self):
        loop = Loop(0.7)
        loop.ask(1000.0)
        K = loop.used[2, 0]
        self.assertTrue(LOWER < K < 1000.0)
        self.assertAlmostEqual(loop.used[1, 0], 1.4 * math.sqrt(M * K))

    def test_a_request_that_is_no_number_is_refused(self):
        loop = Loop(1.0)
        for bad in (math.nan, math.inf):
            good = vpic.advance_vpic(
                np.zeros((3, 1)), np.zeros((2, 1)), np.zeros(1),
                np.array([bad]), H, np.ones(1), loop.wanted, loop.law,
                loop.memory, loop.virtual, loop.used,
            )  # fmt: skip
            self.assertFalse(good)

    def test_the_rule_settles_at_twice_its_rest_at_the_error_scale(self):
        rest, scale, slide, forgetting = 6000.0, 3e-4, 20.0, 0.5
        gain = rest * forgetting / (slide * scale**2)
        K = rest
        for _ in range(20000):
            K = vpic.ask_stiffness(
                K, rest, gain, slide, forgetting, scale, 0.0, H
            )
        self.assertAlmostEqual(K, 2 * rest, delta=2.0)
        for _ in range(20000):
            K = vpic.ask_stiffness(
                K, rest, gain, slide, forgetting, 0.0, 0.0, H
            )
        self.assertAlmostEqual(K, rest, delta=2.0)


if __name__ == "__main__":
    unittest.main()

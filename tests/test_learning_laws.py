"""Rewards, limits, actions and subjects against numbers made by hand."""

import math
import unittest

import numpy as np

from brace_drake.core.errors import EffectError, ScenarioError
from brace_drake.laws.cubic import calc_cubic
from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.rewards import (
    EpisodeLimits,
    RewardNumbers,
    barrier,
    calc_reward,
    find_violation,
    improved,
)
from brace_drake.learning.signals import (
    Signals,
    observe_all,
    observe_stage,
    signals_of_estimate,
)
from brace_drake.learning.subjects import (
    EffectRange,
    SubjectRanges,
    between_patients,
    check_ranges,
    draw_subject,
    uses_of,
)

REST = Signals(*np.zeros((5, 6)))


def signals(**coordinates):
    """Signals at rest but for some, as in position=(1, -0.002)."""
    arrays = {name: np.zeros(6) for name in Signals._fields}
    for name, (i, value) in coordinates.items():
        arrays[name][i] = value
    return Signals(**arrays)


class TestPaperReward(unittest.TestCase):
    def test_equations_11_to_16_by_hand(self):
        s = Signals(
            desired=np.array([0, -0.004, 0, 0, 0, 0.0]),
            desired_rate=np.array([0, -0.001, 0, 0, 0, 0.0]),
            position=np.array([0.001, -0.0035, -0.002, 0.1, 0.2, 0.3]),
            rate=np.array([0.5, 0.0015, 0.5, 0.5, 0.5, 0.5]),
            force=np.array([7.0, 3.9, -2.0, 0, 0, 0]),
        )
        terms = calc_reward(s, np.zeros(1), RewardNumbers())
        position = 2 * math.exp(-((80 * -0.0005) ** 2))
        position += 2 * math.exp(-((80 * 0.001) ** 2))
        position += 2 * math.exp(-((80 * 0.002) ** 2))
        self.assertAlmostEqual(terms["position"], position, places=14)
        velocity = 2 * math.exp(-((80 * 0.0025) ** 2))
        self.assertAlmostEqual(terms["velocity"], velocity, places=14)
        force = 2 * math.exp(-((5 * 0.1) ** 2))
        self.assertAlmostEqual(terms["force"], force, places=14)
        self.assertEqual(set(terms), {"position", "velocity", "force"})

    def test_it_pays_for_pressing_with_4_newton_and_not_for_less(self):
        pay = [
            calc_reward(signals(force=(1, F)), np.zeros(1), RewardNumbers())[
                "force"
            ]
            for F in (0.0, 3.0, 4.0, 5.0)
        ]
        self.assertEqual(pay[2], 2.0)
        self.assertLess(pay[0], 1e-100)
        self.assertAlmostEqual(pay[1], pay[3])


class TestBarrier(unittest.TestCase):
    def test_it_is_free_below_its_share_and_costs_its_weight_at_the_limit(self):
        limit = np.full(4, 4.0)
        cost = barrier(np.array([3.2, -4.0, 3.6, 4.8]), limit, 0.8)
        np.testing.assert_allclose(cost, [0, -1, -0.25, -3], atol=1e-12)

    def test_the_improved_reward_wants_tracking_and_calm(self):
        best = calc_reward(REST, np.zeros(1), improved())
        self.assertEqual(sum(best.values()), 8.0)
        late = calc_reward(
            signals(position=(1, 0.0004)), np.zeros(1), improved()
        )
        self.assertAlmostEqual(late["position"], 4 + 2 / math.e, places=12)
        nervous = calc_reward(REST, np.array([0.5]), improved())
        self.assertEqual(nervous["smoothness"], -1.25)


class TestLimits(unittest.TestCase):
    def check(self, **coordinates):
        return find_violation(
            signals(**coordinates), EpisodeLimits(), ("ring2",)
        )

    def test_equations_17_to_19_end_an_episode_just_beyond(self):
        for name, i, limit in (
            ("position", 1, 0.006), ("position", 1, -0.4), ("rate", 1, 0.6),
            ("rate", 1, -0.6), ("force", 1, 50.0), ("force", 1, -50.0),
            ("position", 0, 0.02), ("position", 0, -0.02),
            ("position", 2, 0.02), ("position", 2, -0.02),
        ):  # fmt: skip
            with self.subTest(name=name, i=i, limit=limit):
                self.assertEqual(self.check(**{name: (i, limit)}), "")
                beyond = self.check(**{name: (i, limit * 1.0001)})
                self.assertIn("ring2 " + "xyz"[i], beyond)

    def test_other_coordinates_are_free(self):
        self.assertEqual(self.check(position=(3, 1.0), force=(0, 99.0)), "")


class TestObservations(unittest.TestCase):
    numbers = Signals(*np.arange(30.0).reshape(5, 6))

    def test_the_paper_s_seven_are_in_its_order(self):
        np.testing.assert_array_equal(
            observe_stage(self.numbers), [1, 7, 13, 19, 25, 12, 14]
        )

    def test_all_of_them_are_pose_desired_pose_rates_and_force(self):
        out = observe_all(self.numbers)
        blocks = out.reshape(5, 6)[:, 0]
        np.testing.assert_array_equal(blocks, [12, 0, 18, 6, 24])

    def test_force_is_that_of_the_torso(self):
        s = signals_of_estimate(np.arange(18.0), np.zeros(18))
        np.testing.assert_array_equal(s.force, -np.arange(12.0, 18.0))


class TestActions(unittest.TestCase):
    def law(self, scale):
        return ActionLaw(500.0, 50000.0, np.array([5000.0]), scale, 0.4)

    def test_ends_and_middle_of_the_range(self):
        ends = np.array([-1.0, 0.0, 1.0])
        for scale, middle in (("linear", 25250.0), ("log", 5000.0)):
            K = self.law(scale).stiffness(ends)
            np.testing.assert_allclose(K, [500, middle, 50000])
            back = self.law(scale).action(K)
            np.testing.assert_allclose(back, ends, atol=1e-12)

    def test_rate_and_bounds_hold_whatever_is_asked(self):
        law, a = self.law("log"), np.zeros(1)
        a = law.limit(np.array([1e9]), a)
        self.assertAlmostEqual(a[0], 0.4)
        for _ in range(5):
            a = law.limit(np.array([np.inf]), a)
        self.assertEqual(a[0], 1.0)
        self.assertEqual(law.limit(np.array([np.nan]), a)[0], 1.0)


class TestCubic(unittest.TestCase):
    def test_it_rests_at_both_ends_and_its_rates_are_its_derivatives(self):
        out, ends = np.empty((5, 3)), (-1.0, 0.0, 6.0, 12.0, 13.0)
        for row, t in zip(out, ends, strict=True):
            calc_cubic(t, 12.0, np.array([0.1]), np.array([-0.01]), row)
        np.testing.assert_allclose(out[:, 0], [0.1, 0.1, 0.095, 0.09, 0.09])
        # 1.5 L / T in the middle.
        np.testing.assert_allclose(out[:, 1], [0, 0, -0.00125, 0, 0])
        np.testing.assert_allclose(out[[0, 2, 4], 2], 0.0, atol=1e-15)
        h, way = 1e-4, np.array([-0.01])
        near = np.empty((3, 3))
        for row, t in zip(near, (4 - h, 4.0, 4 + h), strict=True):
            calc_cubic(t, 12.0, np.zeros(1), way, row)
        for k in (0, 1):
            slope = (near[2, k] - near[0, k]) / (2 * h)
            self.assertAlmostEqual(slope, near[1, k + 1], places=9)


class TestSubjects(unittest.TestCase):
    def test_off_by_default(self):
        subject = draw_subject(SubjectRanges(), np.random.default_rng(1))
        self.assertEqual(set(subject.factors.values()), {1.0})

    def test_draws_stay_in_their_ranges_and_fill_them(self):
        rng = np.random.default_rng(3)
        k = [
            draw_subject(between_patients(), rng).factors["torso_mass"]
            for _ in range(400)
        ]
        self.assertGreaterEqual(min(k), 0.7)
        self.assertLessEqual(max(k), 1.5)
        self.assertLess(abs(np.mean(k) - 1.1), 0.05)

    def test_effects_that_a_subject_has_not_are_off(self):
        ranges = SubjectRanges(
            effects=[
                EffectRange(
                    "coulomb_friction", "", 0.5, {"coulomb_N": [1.0, 2.0]}
                )
            ]
        )
        rng = np.random.default_rng(5)
        drawn = [
            uses_of(ranges, draw_subject(ranges, rng))[0][1][0]
            for _ in range(200)
        ]
        present = np.array(drawn) > 0.0
        self.assertTrue((np.array(drawn)[present] >= 1.0).all())
        self.assertLess(abs(present.mean() - 0.5), 0.12)

    def test_bad_ranges_are_named(self):
        with self.assertRaisesRegex(ScenarioError, "subjects.preload"):
            check_ranges(SubjectRanges(preload=np.array([2.0, 1.0])))
        bad = EffectRange("coulomb_friction", parameters={"mu": [0, 1]})
        with self.assertRaisesRegex(EffectError, "coulomb_N"):
            check_ranges(SubjectRanges(effects=[bad]))


if __name__ == "__main__":
    unittest.main()

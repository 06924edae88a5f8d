"""The criterion, and verdicts on fits whose rests are known."""

import math
import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.registry import find_effect
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, closed_amplitude
from brace_drake.selection.decision import contradict, decide
from brace_drake.selection.level import chance_of, level_of
from brace_drake.selection.tolerated import is_within
from tests.known_fits import COUNT, fit_of


def verdict(gap, *fits, recorded=1.0):
    """Of a campaign whose gap is so many floors."""
    return decide(Criterion(fit_of("", gap), COUNT, recorded), fits)


class TestCriterion(unittest.TestCase):
    def setUp(self):
        self.nominal = fit_of("", 10.0, 10.0)
        self.criterion = Criterion(self.nominal, 1000)

    def test_an_effect_pays_if_it_leaves_less_than_a_quarter(self):
        quarter = 0.25 * (10.0 + thresholds.TRUST) - thresholds.TRUST
        for factor, pays in ((0.95, True), (1.05, False)):
            left = factor * quarter
            fit = fit_of("relaxation", left)
            score = self.criterion.score(fit)
            self.assertEqual(score < self.criterion.score(self.nominal), pays)

    def test_what_imitates_a_gap_in_sample_alone_is_not_named(self):
        imitates = fit_of("force_scale", 1.0, 9.0)
        verdict = decide(self.criterion, [imitates])
        self.assertEqual(verdict.effects, ())
        self.assertTrue(verdict.outside_library)

    def test_less_than_a_twin_is_exact_to_says_nothing(self):
        one = fit_of("relaxation", thresholds.TRUST, thresholds.TRUST)
        two = fit_of("relaxation+force_bias", 0.0, 0.0)
        verdict = decide(self.criterion, [two, one])
        self.assertEqual(verdict.effects, ("relaxation",))
        self.assertFalse(verdict.outside_library)

    def test_a_certain_effect_is_named_beside_a_rest_that_is_unknown(self):
        large = Criterion(fit_of("", 1000.0, 1000.0), 1000)
        fits = [
            fit_of("coulomb_friction", 60.0, 65.0),
            fit_of("relaxation", 950.0, 950.0),
        ]
        verdict = decide(large, fits)
        self.assertEqual(verdict.effects, ("coulomb_friction",))
        self.assertTrue(verdict.outside_library)
        self.assertGreater(verdict.supported[0].probability, 0.9)
        self.assertGreater(verdict.unexplained, thresholds.MATERIAL)
        # An effect that takes next to nothing is not supported.
        self.assertEqual(decide(large, fits[1:]).effects, ())

    def test_a_tolerance_that_is_stretched_far_costs_more_than_an_effect(self):
        stretched = replace(fit_of("", 0.0, 0.0), stretch=8.0)
        effect = fit_of("ring_mass", 0.0, 0.0)
        criterion = Criterion(stretched, 1000)
        self.assertLess(criterion.score(effect), criterion.score(stretched))

    def test_an_effect_within_its_tolerance_is_no_finding(self):
        card = find_effect("ring_mass")
        use = ((card, np.array([0.015])),)
        nuisances = [Nuisance("ring_mass_kg", "kg", "mechanism", 0.015, use)]
        for mass, within in ((0.03, True), (-0.03, True), (0.15, False)):
            found = is_within((card, np.array([mass])), None, nuisances)
            self.assertEqual(found, within)
        other = find_effect("relaxation")
        use = (other, other.starts()[0])
        self.assertFalse(is_within(use, None, nuisances))

    def test_no_effect_closes_more_than_all_of_the_gap(self):
        fits = [
            fit_of("relaxation+force_bias", 0.0, 0.0),
            # Beside this one the gap would be wider than without any.
            fit_of("relaxation", 40.0, 40.0),
        ]
        verdict = decide(self.criterion, fits)
        self.assertEqual(set(verdict.effects), {"relaxation", "force_bias"})
        for support in verdict.supported:
            self.assertAlmostEqual(support.closes, 1.0, places=2)

    def test_all_that_friction_adds_at_rest_is_held_against_its_tolerance(self):
        coulomb, stribeck = map(
            find_effect, ("coulomb_friction", "stribeck_friction")
        )
        use = ((coulomb, np.array([0.03])),)
        number = Nuisance("friction_N", "N", "actuation", 0.03, use)
        # Three deviations are within.
        for extra, within in ((0.05, True), (0.07, False)):
            friction = stribeck, np.array([0.03, extra, 0.002])
            self.assertEqual(is_within(friction, None, [number]), within)

    def test_probabilities_of_all_explanations_are_one(self):
        verdict = decide(self.criterion, [fit_of("relaxation", 0.05, 0.05)])
        self.assertTrue(0.5 < verdict.probability <= 1.0)
        self.assertTrue(math.isfinite(verdict.probability))

    def test_all_of_a_gap_is_closed_at_the_floor_and_none_without_one(self):
        self.assertEqual(closed_amplitude(8.0, -0.1), 1.0)
        self.assertAlmostEqual(closed_amplitude(8.0, 3.0), 0.5)
        self.assertEqual(closed_amplitude(-0.1, 0.0), 0.0)


class TestVerdict(unittest.TestCase):
    def test_a_rest_within_noise_is_no_gap(self):
        found = verdict(0.05, fit_of("force_bias", 0.04))
        self.assertFalse(found.gap)
        self.assertEqual(found.effects, ())
        self.assertEqual(found.unexplained, 0.0)

    def test_the_effect_that_leaves_least_is_named(self):
        found = verdict(
            50.0, fit_of("force_bias", 0.01), fit_of("ring_mass", 20.0)
        )
        self.assertEqual(found.effects, ("force_bias",))
        self.assertEqual(found.ambiguous_with, ())
        self.assertGreater(found.probability, 0.85)

    def test_what_leaves_as_little_is_tied(self):
        found = verdict(
            50.0, fit_of("force_gain", 0.01), fit_of("ring_mass", 0.011)
        )
        self.assertEqual(found.ambiguous_with, ("ring_mass",))
        # Both leave nearly as much; that this is no gap is likely, not sure.
        less = (0.01 + thresholds.TRUST) / (0.011 + thresholds.TRUST)
        share = 1.0 / (1.0 + less**thresholds.ODDS)
        rest = 0.01 + thresholds.LEVEL
        beyond = thresholds.BEYOND_LEVEL * thresholds.LEVEL
        sure = 1.0 / (1.0 + (rest / beyond) ** thresholds.ODDS)
        self.assertAlmostEqual(found.probability, share * sure)

    def test_a_search_that_has_not_ended_decides_nothing(self):
        early = fit_of("ring_mass", 0.0, refined=False)
        found = verdict(50.0, fit_of("force_gain", 0.01), early)
        self.assertEqual(found.effects, ("force_gain",))
        self.assertEqual(found.ambiguous_with, ())

    def test_what_is_not_recorded_makes_every_answer_less_sure(self):
        bias = fit_of("force_bias", 0.01)
        for gap, fits in (
            (0.05, [fit_of("force_bias", 0.04)]),
            (50.0, [bias, fit_of("ring_mass", 20.0)]),
            (50.0, [fit_of("force_bias", 20.0)]),
        ):
            whole = verdict(gap, *fits)
            part = verdict(gap, *fits, recorded=0.5)
            self.assertEqual(part.effects, whole.effects)
            expected = 0.5 + 0.5 * (whole.probability - 0.5)
            self.assertAlmostEqual(part.probability, expected)

    def test_a_gap_that_nothing_explains_is_outside(self):
        found = verdict(50.0, fit_of("force_bias", 20.0))
        self.assertTrue(found.gap and found.outside_library)
        self.assertEqual(found.effects, ())
        self.assertGreater(found.unexplained, 0.95)

    def test_a_second_effect_has_to_pay(self):
        single = fit_of("force_bias", 0.5)
        poor = fit_of("force_bias+ring_mass", 0.3)
        good = fit_of("force_bias+ring_mass", 0.01)
        self.assertEqual(verdict(50.0, single, poor).effects, ("force_bias",))
        found = verdict(50.0, single, good).effects
        self.assertEqual(set(found), {"force_bias", "ring_mass"})

    def test_two_that_leave_little_of_a_large_gap_are_named(self):
        gap, both = 12_000.0, "saturation (drive)+hysteresis"
        one = fit_of("saturation (drive)", 10.0)
        found = verdict(gap, one, fit_of(both, 1.1))
        self.assertEqual(set(found.effects), {"saturation", "hysteresis"})
        found = verdict(gap, one, fit_of(both, 4.0))
        self.assertEqual(found.effects, ("saturation",))

    def test_a_second_effect_that_took_little_is_less_sure(self):
        def probability(rest):
            pair = fit_of("force_bias+ring_mass", rest)
            found = verdict(50.0, fit_of("force_bias", 0.9), pair)
            self.assertEqual(found.winner, pair)
            return found.probability

        sure = [probability(rest) for rest in (0.2, 0.1, 0.0)]
        self.assertEqual(sure, sorted(sure))
        self.assertLess(sure[0], 0.6)
        self.assertGreater(sure[2], 0.75)

    def test_what_is_no_draw_neither_explains_nor_rivals(self):
        drawn = fit_of("anchor_error", 0.01, scattered=False)
        self.assertTrue(verdict(50.0, drawn).outside_library)
        found = verdict(50.0, fit_of("force_bias", 0.01), drawn)
        self.assertEqual(found.effects, ("force_bias",))
        self.assertEqual(found.ambiguous_with, ())

    def test_a_pair_is_no_rival_of_itself(self):
        one = fit_of("force_bias+ring_mass", 0.01)
        same = fit_of("ring_mass+force_bias", 0.011)
        found = verdict(50.0, fit_of("force_bias", 20.0), one, same)
        self.assertEqual(found.ambiguous_with, ())
        self.assertGreater(found.probability, 0.85)

    def test_probability_falls_with_rivals_and_with_what_is_left(self):
        bias = fit_of("force_bias", 0.01)
        of_rivals = [
            verdict(50.0, bias, fit_of("ring_mass", rest)).probability
            for rest in (0.02, 0.2, 2.0)
        ]
        self.assertEqual(of_rivals, sorted(of_rivals))
        of_rest = [
            verdict(50.0, fit_of("force_bias", rest)).probability
            for rest in (0.0, 0.1, 0.2)
        ]
        self.assertEqual(of_rest, sorted(of_rest, reverse=True))

    def test_no_effect_is_less_probable_than_the_whole_verdict(self):
        fits = [
            fit_of("force_bias", 3.0),
            fit_of("force_bias+ring_mass", 0.1),
            fit_of("force_bias+force_lag", 0.2),
        ]
        for number in (1, 2, 3):
            found = verdict(50.0, *fits[:number])
            for support in found.supported:
                self.assertGreaterEqual(support.probability, found.probability)

    def test_what_chance_leaves_is_neither_outside_nor_against_an_effect(self):
        # Drives that slip by chance: a right twin leaves as much as it does.
        chance = 120.0
        level = thresholds.LEVEL + chance
        fits = [fit_of("stribeck_friction", 44.0), fit_of("breathing", 700.0)]
        for gap, named in ((90.0, ()), (785.0, ("stribeck_friction",))):
            criterion = Criterion(
                fit_of("", gap), COUNT, level=level, chance=chance
            )
            found = decide(criterion, fits)
            self.assertEqual(found.effects, named)
            self.assertFalse(found.outside_library)
            self.assertFalse(criterion.may_pay(fits[0]))
        # Were it the error of a law, which all fits share, it would say less.
        criterion = replace(criterion, chance=0.0)
        self.assertEqual(decide(criterion, fits).effects, ())

    def test_what_is_contradicted_is_withdrawn_and_held_for_improbable(self):
        before = verdict(50.0, fit_of("force_bias", 0.01))
        after = contradict(before, "it is worse")
        self.assertTrue(after.gap and after.outside_library)
        self.assertEqual((after.effects, after.winner), ((), None))
        self.assertAlmostEqual(after.probability, 1.0 - before.probability)
        self.assertEqual(after.contradicted, "it is worse")


class TestLevel(unittest.TestCase):
    def test_friction_adds_to_what_a_right_twin_leaves(self):
        # What friction of one tolerance changes: three floors everywhere.
        evaluator = SimpleNamespace(
            count=COUNT,
            prepared=[],
            map=lambda function, tasks: [function(*t) for t in tasks],
            changes=lambda subject, uses, more: [
                np.full(COUNT, 30.0 * one[0][1][0]) for one in more
            ],
        )
        none = fit_of("relaxation", 0.1)
        self.assertEqual(level_of(evaluator, none), thresholds.LEVEL)
        for strength, factor in ((0.1, 1.0), (0.2, 4.0), (1.0, 100.0)):
            rough = fit_of("coulomb_friction", 0.1)
            rough = replace(rough, values=(np.array([strength]),))
            found = level_of(evaluator, rough)
            found -= thresholds.LEVEL
            expected = factor * thresholds.TRUST**2 * 9.0
            self.assertAlmostEqual(found, expected)

    def test_chance_beyond_the_noise_adds_to_it(self):
        def recorded(seed):
            return SimpleNamespace(
                seed=seed, index=seed, motion=None, weigh=lambda x: x
            )

        for scatter, chance in ((1.0, 0.0), (2.0, 3.0)):
            twin = SimpleNamespace(
                carried=(),
                has_loop=True,
                simulate_each=lambda requests, s=scatter: [
                    s * np.random.default_rng(r.seed).standard_normal(COUNT)
                    for r in requests
                ],
            )
            evaluator = SimpleNamespace(
                twin=twin,
                count=2 * COUNT,
                prepared=[recorded(0), recorded(1)],
                map=lambda function, tasks: [function(*t) for t in tasks],
            )
            fit = fit_of("coulomb_friction", 0.1)
            self.assertAlmostEqual(chance_of(evaluator, fit), chance, delta=0.4)


if __name__ == "__main__":
    unittest.main()

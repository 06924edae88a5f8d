"""Verdicts on fits whose rests are known."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.effects.registry import find_effect
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import decide, sure_of_effects

COUNT = 1000
NULL = SimpleNamespace(misfit_threshold=0.1, least_gain=lambda n: 0.03)


def fit(rest, *names, refined=True, scattered=True):
    """A fit that leaves `rest` floors above noise."""
    cards = tuple(find_effect(name) for name in names)
    kinds = tuple(card.name for card in cards)
    return SimpleNamespace(
        effects=cards,
        identifiers=kinds,
        kinds=frozenset(kinds),
        name="+".join(names),
        excess=rest * COUNT,
        refined=refined,
        uses=tuple((card, np.zeros(9)) for card in cards),
        freedom=sum(len(card.parameters) for card in cards),
        subject=np.zeros(6),
        is_scattered=scattered,
        is_flexible=any(card.is_flexible for card in cards),
        sticks=any(card.sticks for card in cards),
        is_dithered=any(card.dithered for card in cards),
    )


def criterion(gap, recorded=1.0, null=NULL):
    """Of a bench whose gap is a fit, with known instruments."""
    return Criterion(gap, COUNT, True, recorded, null=null)


def verdict(gap, *fits, recorded=1.0, null=NULL):
    return decide(criterion(fit(gap), recorded, null), fits)


class TestVerdict(unittest.TestCase):
    def test_what_a_part_of_the_machine_shows_has_to_be_among_the_effects(self):
        friction = fit(0.9, "coulomb_friction")
        pair = fit(1.1, "coulomb_friction", "relaxation")
        fits, gap = [friction, pair], fit(500.0)
        self.assertIs(decide(criterion(gap), fits).winner, friction)
        shown = frozenset({"relaxation"})
        seen = decide(criterion(gap), fits, shown=shown)
        self.assertIs(seen.winner, pair)
        alone = decide(criterion(gap), [friction], shown=shown)
        self.assertIs(alone.winner, friction)

    def test_a_rest_within_noise_is_no_gap(self):
        self.assertFalse(verdict(0.05, fit(0.04, "force_bias")).gap)

    def test_the_effect_that_leaves_least_is_named(self):
        found = verdict(50.0, fit(0.01, "force_bias"), fit(20.0, "ring_mass"))
        self.assertEqual(found.winner.identifiers, ("force_bias",))
        self.assertEqual(found.ambiguous_with, ())
        self.assertGreater(found.probability, 0.85)

    def test_what_leaves_as_little_is_tied(self):
        found = verdict(50.0, fit(0.01, "force_gain"), fit(0.012, "ring_mass"))
        self.assertEqual(found.ambiguous_with, ("ring_mass",))
        self.assertLess(found.probability, 0.5)

    def test_what_leaves_as_little_before_its_search_has_ended_is_tied_too(
        self,
    ):
        rival = fit(0.012, "ring_mass", refined=False)
        found = verdict(50.0, fit(0.01, "force_gain"), rival)
        self.assertEqual(found.ambiguous_with, ("ring_mass",))
        many = fit(0.012, "anchor_error", refined=False, scattered=False)
        found = verdict(50.0, fit(0.01, "force_gain"), many)
        self.assertEqual(found.ambiguous_with, ())

    def test_what_is_not_recorded_makes_every_answer_less_sure(self):
        for gap, fits in (
            (0.05, [fit(0.04, "force_bias")]),
            (50.0, [fit(0.01, "force_bias"), fit(20.0, "ring_mass")]),
            (50.0, [fit(20.0, "force_bias")]),
        ):
            whole = verdict(gap, *fits)
            part = verdict(gap, *fits, recorded=0.5)
            self.assertEqual(part.winner, whole.winner)
            expected = 0.5 + 0.5 * (whole.probability - 0.5)
            self.assertAlmostEqual(part.probability, expected)

    def test_no_gap_below_a_high_threshold_says_less(self):
        high = SimpleNamespace(misfit_threshold=1.0, least_gain=lambda n: 0.03)
        low = verdict(0.0, fit(0.0, "force_bias")).probability
        found = verdict(0.0, fit(0.0, "force_bias"), null=high)
        self.assertFalse(found.gap)
        self.assertLess(found.probability, 0.6)
        self.assertGreater(low, 0.9)

    def test_a_gap_that_nothing_explains_is_outside(self):
        found = verdict(50.0, fit(20.0, "force_bias"))
        self.assertTrue(found.outside_library)

    def test_a_second_effect_has_to_pay(self):
        single = fit(0.5, "force_bias")
        poor = fit(0.3, "force_bias", "ring_mass")
        good = fit(0.01, "force_bias", "ring_mass")
        self.assertEqual(len(verdict(50.0, single, poor).winner.effects), 1)
        self.assertEqual(len(verdict(50.0, single, good).winner.effects), 2)

    def test_what_the_noises_level_may_be_off_hides_no_second_effect(self):
        single = fit(0.14, "force_bias")
        for rest, second, number in (
            (0.03, "ring_mass", 2),
            (0.1, "ring_mass", 2),
            (0.12, "ring_mass", 1),
            (-0.02, "ring_mass", 2),
            # Averaged over noise, which is no nearer.
            (0.1, "hysteresis", 1),
            (0.03, "hysteresis", 2),
        ):
            with self.subTest(rest=rest, second=second):
                pair = fit(rest, "force_bias", second)
                found = verdict(50.0, single, pair).winner
                self.assertEqual(len(found.effects), number)
        # What noise might gain is no second effect.
        pair = fit(0.03, "force_bias", "ring_mass")
        rough = SimpleNamespace(misfit_threshold=0.1, least_gain=lambda n: 0.2)
        found = verdict(50.0, single, pair, null=rough).winner
        self.assertEqual(len(found.effects), 1)
        # No level of noise is off by more than that.
        single = fit(0.9, "force_bias")
        pair = fit(0.3, "force_bias", "ring_mass")
        found = verdict(50.0, single, pair).winner
        self.assertEqual(len(found.effects), 1)

    def test_a_second_effect_that_took_little_is_less_sure(self):
        def probability(rest, *others):
            pair = fit(rest, "force_bias", "ring_mass")
            found = verdict(9.0, fit(0.09, "force_bias"), pair, *others)
            self.assertEqual(found.winner, pair)
            return found.probability, found.ambiguous_with

        sure = [probability(rest)[0] for rest in (0.055, 0.03, -0.1)]
        self.assertEqual(sure, sorted(sure))
        self.assertLess(sure[0], 0.85)
        self.assertGreater(sure[2], 0.9)
        # Another second effect that took next to nothing is no rival.
        other = fit(0.088, "force_bias", "force_lag", refined=False)
        self.assertEqual(probability(0.03, other), (sure[1], ()))
        close = fit(0.031, "force_bias", "force_lag", refined=False)
        _, tied = probability(0.03, close)
        self.assertEqual(tied, ("force_bias+force_lag",))

    def test_what_is_no_draw_neither_explains_nor_rivals(self):
        drawn = fit(0.01, "anchor_error", scattered=False)
        self.assertTrue(verdict(50.0, drawn).outside_library)
        found = verdict(50.0, fit(0.01, "force_bias"), drawn)
        self.assertEqual(found.winner.identifiers, ("force_bias",))
        self.assertEqual(found.ambiguous_with, ())

    def test_a_richer_form_that_gains_nothing_is_no_rival(self):
        plain = fit(0.1, "coulomb_friction")
        same = fit(0.099, "stribeck_friction")
        found = verdict(50.0, plain, same)
        self.assertIs(found.winner, plain)
        self.assertEqual(found.ambiguous_with, ())
        other = fit(0.099, "viscous_leg")
        found = verdict(50.0, plain, other)
        self.assertEqual(found.ambiguous_with, ("coulomb_friction",))

    def test_a_pair_is_no_rival_of_itself(self):
        one = fit(0.01, "force_bias", "ring_mass")
        same = fit(0.011, "ring_mass", "force_bias")
        found = verdict(50.0, fit(20.0, "force_bias"), one, same)
        self.assertEqual(found.ambiguous_with, ())
        self.assertGreater(found.probability, 0.85)

    def test_a_rest_within_noise_takes_nothing_of_the_probability(self):
        small = verdict(0.3, fit(0.08, "force_bias"), fit(0.28, "ring_mass"))
        bare = verdict(50.0, fit(0.08, "force_bias"), fit(0.28, "ring_mass"))
        self.assertAlmostEqual(small.probability, bare.probability)

    def test_one_may_leave_a_share_of_the_gap_and_two_no_more_than_noise(self):
        gap = fit(99.0)
        # sqrt(1 + 99) - 1 = 9 floors of amplitude, a fifth of them is 1.8.
        one = criterion(gap).largest_rest(1)
        self.assertAlmostEqual(one, 2.8**2 - 1.0)
        self.assertEqual(criterion(gap).largest_rest(2), 1.0)
        # Of a large one a hundredth.
        exact = criterion(fit(300.0**2 - 1.0)).largest_rest(2)
        self.assertAlmostEqual(exact, 3.99**2 - 1.0)
        # Of an amplitude a tenth, which is squared.
        rough = criterion(gap).largest_rest(2, True)
        before, after = (np.sqrt(1.0 + r) - 1.0 for r in (99.0, rough))
        self.assertAlmostEqual(after / before, 0.1)

    def test_two_that_leave_little_of_a_large_gap_are_named(self):
        gap, pair = 12_000.0, ("saturation", "hysteresis")
        one = fit(10.0, "saturation")
        self.assertEqual(
            verdict(gap, one, fit(1.1, *pair)).winner.kinds, {*pair}
        )
        self.assertIs(verdict(gap, one, fit(4.0, *pair)).winner, one)
        # Of a gap of 100 floors that is too much.
        found = verdict(100.0, fit(5.0, "saturation"), fit(1.1, *pair))
        self.assertEqual(found.winner.kinds, {"saturation"})

    def test_two_of_few_parameters_are_named_before_one_of_dozens(self):
        # Anchors cover much of any gap; beside them two need only leave less.
        anchors, bias = fit(0.12, "anchor_error"), fit(0.12, "force_bias")
        pair = fit(0.09, "force_scale", "leg_compliance")
        found = verdict(2.0, anchors, pair)
        self.assertEqual(found.winner, pair)
        self.assertEqual(found.ambiguous_with, ("anchor_error",))
        self.assertLess(found.probability, 0.5)
        self.assertEqual(verdict(2.0, bias, pair).winner, bias)
        worse = fit(0.13, "force_scale", "leg_compliance")
        self.assertEqual(verdict(2.0, anchors, worse).winner, anchors)

    def test_where_drives_stick_a_bit_more_counts_as_the_floor(self):
        def is_near(rest, name, gap=9.0):
            return criterion(fit(gap)).is_near_floor([fit(rest, name)])

        self.assertTrue(is_near(0.09, "force_bias"))
        self.assertFalse(is_near(0.3, "force_bias"))
        self.assertTrue(is_near(0.3, "coulomb_friction"))
        self.assertFalse(is_near(0.6, "coulomb_friction"))
        # Averaged over noise too, but no drive sticks with it.
        self.assertFalse(is_near(0.3, "hysteresis"))
        # Of a small gap friction takes nothing: something else may.
        self.assertFalse(is_near(0.3, "coulomb_friction", gap=0.32))

    def test_probability_falls_with_rivals_and_with_what_is_left(self):
        of_contrast = [sure_of_effects(c, 0.0, 1) for c in (1.0, 3.0, 30.0)]
        self.assertEqual(of_contrast, sorted(of_contrast))
        of_rest = [sure_of_effects(30.0, r, 1) for r in (0.0, 0.1, 0.2)]
        self.assertEqual(of_rest, sorted(of_rest, reverse=True))


if __name__ == "__main__":
    unittest.main()

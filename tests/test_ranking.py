"""Explanations that are tied are told apart by the numbers that they need."""

import math
import unittest
from dataclasses import replace

import numpy as np
from scipy.stats import t as student

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.effects.registry import find_effect
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, cost_of
from brace_drake.selection.decision import decide
from brace_drake.selection.ranking import prior_cost, rank
from brace_drake.selection.search.sets import beam_of
from brace_drake.selection.search.shortlist import rivals
from tests.known_fits import COUNT, fit_of

# Degrees of freedom that the docs of `TAIL` state.
STUDENT = student(9)
# What one deviation of the number changes: the noise tells next to nothing.
FAR = 1e4


def needing(fit, deviations):
    """A fit that needs a number, known to a tolerance, to be so far off."""
    mass = Nuisance("ring_mass_kg", "kg", "mechanism", 0.015, ())
    basis = np.eye(COUNT, 1)
    known = LinearTolerances((mass,), basis, np.array([[FAR]]))
    rest = known.whiten(-FAR * deviations * basis[:, 0])
    solution = replace(fit.solution, residual=rest)
    return replace(fit, tolerances=known, solution=solution)


class TestSearch(unittest.TestCase):
    def test_a_set_that_leaves_less_than_noise_is_built_upon(self):
        criterion = Criterion(fit_of("", 50.0), COUNT)
        below = fit_of("clearance", -0.015)
        others = [fit_of("force_gain", 3.0), fit_of("anchor_error", 9.0)]
        self.assertEqual(beam_of(criterion, [*others, below], 1), [below])

    def test_a_larger_set_pays_if_it_leaves_less_than_is_said(self):
        criterion = Criterion(fit_of("", 50.0), COUNT)
        best = fit_of("clearance", 3.0)
        most = criterion.pays_below(best, 3) / COUNT
        for part, pays in ((0.98, True), (1.02, False)):
            three = fit_of("clearance+force_gain+force_bias", part * most)
            scores = criterion.score(three), criterion.score(best)
            self.assertEqual(scores[0] < scores[1], pays)


class TestRanking(unittest.TestCase):
    def setUp(self):
        self.criterion = Criterion(fit_of("", 50.0), COUNT)

    def scores(self, *fits):
        return {r.fit.name: r.score for r in rank(self.criterion, fits)}

    def test_a_tie_is_broken_by_the_density_of_the_numbers(self):
        scale = needing(fit_of("force_scale", 0.0), 2.5)
        gain = needing(fit_of("force_gain", 0.0), -0.5)
        scores = self.scores(scale, gain)
        odds = thresholds.ODDS * (scores["force_scale"] - scores["force_gain"])
        expected = STUDENT.logpdf(0.5) - STUDENT.logpdf(2.5)
        self.assertAlmostEqual(odds, expected, places=4)
        verdict = decide(self.criterion, [scale, gain])
        self.assertEqual(verdict.effects, ("force_gain",))
        self.assertAlmostEqual(
            verdict.supported[0].probability,
            1.0 / (1.0 + math.exp(-expected)),
            places=2,
        )

    def test_equal_numbers_leave_a_tie(self):
        one = needing(fit_of("force_scale", 0.0), 1.0)
        two = needing(fit_of("force_gain", 0.0), -1.0)
        verdict = decide(self.criterion, [one, two])
        self.assertEqual(len(verdict.ambiguous_with), 1)
        self.assertLess(verdict.probability, 0.51)

    def test_of_what_is_tied_the_fewer_parameters_are_the_likelier(self):
        # A loop that is as deep as the push is a spring that hardens.
        loop, spring = fit_of("hysteresis", 0.0), fit_of("hardening", 0.0)
        scores = self.scores(loop, spring)
        odds = thresholds.ODDS * (scores["hysteresis"] - scores["hardening"])
        # Of its four parameters two are choices.
        self.assertAlmostEqual(odds, 2.0 - 1.0)

    def test_numbers_do_not_speak_for_what_leaves_more_or_needs_more(self):
        one = needing(fit_of("force_scale", 0.0), 2.5)
        for name, left in (("force_gain", 2.0), ("force_gain+weak_leg", 0.0)):
            other = needing(fit_of(name, left), 0.0)
            for fit in (one, other):
                found = self.scores(one, other)[fit.name]
                self.assertEqual(found, self.criterion.score(fit))

    def test_the_same_effects_may_be_two_explanations(self):
        # A mass within its tolerance beside a gain, and one beyond it.
        use = ((find_effect("ring_mass"), np.array([0.015])),)
        mass = Nuisance("ring_mass_kg", "kg", "mechanism", 0.015, use)
        self.criterion = replace(self.criterion, nuisances=(mass,))
        one, other, third = (
            replace(
                fit_of("force_gain+ring_mass", left),
                subject=np.ones(2),
                values=(np.array([0.05]), np.array([kg])),
            )
            for left, kg in ((0.02, 0.01), (0.0, 0.2), (0.01, 0.01))
        )
        scale = fit_of("force_scale", 0.012)
        found = rank(self.criterion, [one, other, third, scale])
        named = [self.criterion.named(r.fit) for r in found]
        self.assertEqual(len(named), 3)
        self.assertEqual(named[0], frozenset({"force_gain"}))
        self.assertIs(found[0].fit, third)
        self.assertEqual(named[-1], frozenset({"force_gain", "ring_mass"}))

    def test_what_leaves_more_is_not_believed_more_for_it(self):
        # Both need the number as far off, beside what the worse one leaves.
        better = needing(fit_of("force_scale", 0.10), 2.5)
        worse = needing(fit_of("force_gain", 0.11), 2.5)
        scores = self.scores(better, worse)
        apart = self.criterion.score(worse) - self.criterion.score(better)
        self.assertAlmostEqual(
            scores["force_gain"] - scores["force_scale"], apart
        )

    def test_beside_much_that_is_unknown_numbers_say_little(self):
        one = needing(fit_of("force_scale", 9.0), 2.5)
        other = needing(fit_of("force_gain", 9.0), 0.0)
        cost = prior_cost(one, one.excess)
        scores = self.scores(one, other)
        share = self.criterion.known(one)
        self.assertLess(share, 0.05)
        self.assertAlmostEqual(
            scores["force_scale"] - scores["force_gain"], share * cost
        )

    def test_what_an_unknown_law_stretches_is_no_reason_for_an_effect(self):
        # Both leave nearly the same, without the effect numbers are stretched.
        for left, first in ((0.0, "force_scale"), (0.5, "nominal")):
            nominal = replace(fit_of("", left + 0.02), stretch=9.0)
            effect = fit_of("force_scale", left)
            criterion = Criterion(nominal, COUNT, is_last=True)
            found = rank(criterion, [nominal, effect])
            self.assertEqual(found[0].fit.name, first)
            verdict = decide(criterion, [effect])
            self.assertEqual(verdict.outside_library, left > 0.0)
        # Nor is it one to doubt that law.
        calm = Criterion(replace(nominal, stretch=0.0), COUNT, is_last=True)
        expected = decide(calm, [effect]).probability
        self.assertAlmostEqual(verdict.probability, expected)

    def test_a_law_that_leaves_much_less_stands_in_place_of_an_effect(self):
        # A law of two terms costs ln 3 more than an effect, all but.
        anchors = fit_of("anchor_error", 1.0)
        for left, is_law in ((0.0, True), (0.4, False)):
            pulls = fit_of("force_bias+force_scale", left)
            criterion = replace(self.criterion, law=pulls)
            verdict = decide(criterion, [anchors])
            self.assertEqual(verdict.outside_library, is_law)
            self.assertEqual(verdict.effects, () if is_law else (anchors.name,))
            apart = criterion.score(anchors) - criterion.score(pulls)
            self.assertEqual(apart > 0.0, is_law)
            if is_law:
                # Beside it what is left without the law is far from noise.
                odds = math.exp(-thresholds.ODDS * apart)
                most = 1.0 - thresholds.UNSURE
                expected = min(1.0 / (1.0 + odds), most)
                self.assertAlmostEqual(verdict.probability, expected, 1)

    def test_any_number_of_effects_is_as_likely_and_so_is_each_set(self):
        for number in range(4):
            sets = math.comb(thresholds.CAUSES, number)
            chance = math.exp(-thresholds.ODDS * cost_of(number))
            self.assertAlmostEqual(chance * sets, 1.0)

    def test_a_number_beyond_its_tolerance_may_be_an_effect(self):
        # At four tolerances an effect in its place would cost ln 4 and save
        # 4 ln(4 / 3), for which 2.5 times the difference are the log odds.
        sure = []
        for stretch in (3.0, 4.0):
            nominal = replace(fit_of("", 0.0), stretch=stretch)
            criterion = Criterion(nominal, COUNT, is_last=True)
            sure.append(decide(criterion, []).probability)
        odds = (4.0 / (4.0 / 3.0) ** 4) ** 2.5
        self.assertAlmostEqual(sure[1] / sure[0], odds / (1.0 + odds))

    def test_what_is_left_may_lie_along_the_number(self):
        # As large a change by an unknown law says nothing of the number.
        fit = needing(fit_of("force_scale", 0.0), 2.5)
        expected = STUDENT.logpdf(0.0) - STUDENT.logpdf(1.25)
        cost = thresholds.ODDS * prior_cost(fit, FAR**2)
        self.assertAlmostEqual(cost, expected, places=4)

    def test_parameters_with_a_prior_count_as_numbers(self):
        fit = fit_of("force_scale", 0.0)
        rest = np.append(fit.solution.residual, [1.5, -0.5])
        solution = replace(fit.solution, residual=rest)
        fit = replace(fit, solution=solution, num_prior=2)
        expected = 2.0 * STUDENT.logpdf(0.0)
        expected -= STUDENT.logpdf(1.5) + STUDENT.logpdf(0.5)
        cost = thresholds.ODDS * prior_cost(fit, 0.0)
        self.assertAlmostEqual(cost, expected)


class TestRivals(unittest.TestCase):
    """What is led on to its end, of the fits of one round of a search."""

    def setUp(self):
        self.base = fit_of("", 50.0)
        self.criterion = Criterion(self.base, COUNT)

    def rivals(self, *fits):
        best = min([self.base, *fits], key=self.criterion.score)
        return rivals(self.criterion, self.base, best, fits)

    def test_those_near_the_best_are_led_on_best_first(self):
        near, best, far = (
            fit_of(name, left)
            for name, left in (
                ("force_gain", 3.0), ("force_scale", 1.0), ("reflex", 9.0),
            )
        )  # fmt: skip
        self.assertEqual(self.rivals(near, best, far), [1, 0])
        unfinished = replace(near, refined=False)
        self.assertEqual(self.rivals(unfinished, best), [1])

    def test_of_the_same_effects_in_two_forms_the_better_one_is(self):
        one = fit_of("coulomb_friction (without creep)", 2.0)
        other = fit_of("coulomb_friction", 1.5)
        self.assertEqual(self.rivals(one, other), [1])

    def test_what_stands_at_its_end_is_not_led_on_again(self):
        best = replace(fit_of("force_scale", 1.0), is_settled=True)
        near = fit_of("force_gain", 3.0)
        self.assertEqual(self.rivals(best, near), [1])

    def test_what_names_nothing_more_is_led_on_where_it_is_best(self):
        card = find_effect("ring_mass")
        use = ((card, np.array([0.015])),)
        mass = Nuisance("ring_mass_kg", "kg", "mechanism", 0.015, use)
        self.criterion = replace(self.criterion, nuisances=(mass,))
        within = replace(fit_of("ring_mass", 2.0), values=(np.array([0.01]),))
        self.assertEqual(self.criterion.findings(within), [])
        better, worse = (fit_of("force_gain", left) for left in (0.2, 8.0))
        self.assertEqual(self.rivals(within, better), [1])
        self.assertEqual(self.rivals(within, worse), [0])


if __name__ == "__main__":
    unittest.main()

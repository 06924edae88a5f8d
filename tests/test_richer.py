"""Effects that set out from a special case of theirs, or from another start."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from brace_drake.effects.registry import find_effect
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.selection.level import make_criterion
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.selection.search.candidate import Candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.nested import (
    richer_starts,
    search_richer,
    special_cases,
)
from brace_drake.selection.search.screening import (
    _best_starts,
    screen,
    search_best,
)
from brace_drake.selection.search.shortlist import best_fits, improve_choices
from brace_drake.selection.settle import settle
from tests.known_fits import fit_of
from tests.synthetic_bench import SyntheticBench

COULOMB, STRIBECK = (
    find_effect(f"{name}_friction") for name in ("coulomb", "stribeck")
)


class TestRicherStarts(unittest.TestCase):
    def test_they_are_as_strong_on_average_as_the_special_case(self):
        starts = list(richer_starts(STRIBECK, COULOMB, np.array([0.8])))
        # From nearly the same force at rest as in motion to several times it.
        ratios = {round((level + more) / level, 6) for level, more, _ in starts}
        self.assertLess(min(ratios), 1.2)
        self.assertGreater(max(ratios), 3.0)
        self.assertEqual(len(starts), 3 * len(ratios))
        for level, added, _ in starts:
            self.assertAlmostEqual(level + 0.5 * added, 0.8)
            self.assertGreater(added, 0.0)
        self.assertEqual(len({speed for *_, speed in starts}), 3)

    def test_they_keep_within_the_limits(self):
        for start in richer_starts(STRIBECK, COULOMB, np.array([60.0])):
            self.assertTrue(np.all(start <= STRIBECK.upper))


class TestSpecialCase(unittest.TestCase):
    def cases_of(self, friction):
        fit = fit_of("leg_compliance (dry friction)", 0.3)
        fit = replace(fit, values=(np.array([1e-6, friction]),))
        keys = "coulomb_friction", "coulomb_friction (without creep)"
        return special_cases(fit, [find_effect(key) for key in keys])

    def test_of_friction_in_a_soft_leg_it_is_friction_in_each_form(self):
        # Within its tolerance too: else a leg that is next to stiff would be
        # an effect.
        for friction in (0.6, 0.05):
            found = self.cases_of(friction)
            names = [f.name for f in found]
            self.assertEqual(len(set(names)), 2)
            for fit in found:
                self.assertEqual(fit.values[0].tolist(), [friction])

    def test_of_what_has_none_there_is_none(self):
        fit = fit_of("force_bias", 0.3)
        self.assertEqual(special_cases(fit, [find_effect("force_drift")]), [])


class TestRicherRace(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()

    def race(self, card, values):
        """Of Coulomb friction alone, then of richer effects from there."""
        evaluator = self.bench.evaluator([(card, np.array(values))])
        ground = Linearisation(evaluator, fit_nominal(evaluator))
        runners = screen(ground, [COULOMB])
        search_best(ground, runners)
        richer = search_richer(ground, best_fits(runners), [COULOMB, STRIBECK])
        return evaluator, best_fits(runners)[0], best_fits(richer)

    def test_large_friction_that_falls_with_speed_is_found_from_coulombs(self):
        evaluator, plain, (found,) = self.race(STRIBECK, [0.8, 0.5, 0.002])
        self.assertEqual(found.name, "stribeck_friction")
        self.assertLess(
            found.excess / evaluator.count, 0.4 * plain.excess / evaluator.count
        )
        self.assertAlmostEqual(found.values[0][0], 0.8, delta=0.08)

    def test_in_the_end_a_richer_form_stands_beside_its_special_case(self):
        evaluator = self.bench.evaluator([(COULOMB, np.array([0.8]))])
        nominal = fit_nominal(evaluator)
        criterion = make_criterion(evaluator, nominal, ())
        # Its friction falls with speed by next to nothing.
        values = np.array([0.78, 0.02, 0.01])
        richer = fit_effects(evaluator, [STRIBECK], [values])
        criterion, fits = settle(evaluator, criterion, [richer])
        best = best_of_kinds(criterion, fits)[0]
        self.assertEqual(best.name, "coulomb_friction")
        self.assertAlmostEqual(best.values[0][0], 0.8, delta=0.01)

    def test_of_coulomb_friction_nothing_richer_is_searched(self):
        _, _, found = self.race(COULOMB, [0.8])
        self.assertEqual(found, [])


class TestOtherForms(unittest.TestCase):
    def test_a_form_goes_on_from_where_another_has_come(self):
        evaluator = SyntheticBench().evaluator([(COULOMB, np.array([2.0]))])
        ground = Linearisation(evaluator, fit_nominal(evaluator))
        holds = find_effect("coulomb_friction (without creep)")
        start = [np.array([1.9])]
        wrong = fit_effects(evaluator, [holds], start, is_compared=True)
        (found,) = improve_choices(ground, [wrong])
        self.assertEqual(found.name, "coulomb_friction")
        self.assertTrue(found.refined)
        self.assertLess(found.excess, 0.5 * wrong.excess)
        self.assertAlmostEqual(found.values[0][0], 2.0, delta=0.02)


def begun(name, start, predicted):
    """A search of an effect that begins somewhere."""
    problem = SimpleNamespace(effects=(find_effect(name),))
    return Candidate(problem, None, None, None, predicted, start)


class TestOtherStarts(unittest.TestCase):
    def test_the_best_from_another_start_is_kept_beside_the_best(self):
        candidates = [
            begun("relaxation", (start,), predicted)
            for start, predicted in (
                (2.0, 1.0),
                (2.0, 2.0),
                (8.0, 3.0),
                (0.5, 4.0),
            )
        ]
        (best,) = _best_starts(candidates)
        self.assertIs(best, candidates[0])
        self.assertEqual(best.others, (candidates[2],))

    def test_a_breath_and_an_effect_of_one_start_have_no_other(self):
        for name, starts in (
            ("breathing", ((0.2,), (0.3,))),
            ("ring_mass", ((), ())),
        ):
            found = [begun(name, s, 1.0) for s in starts]
            (best,) = _best_starts(found)
            self.assertEqual(best.others, ())


if __name__ == "__main__":
    unittest.main()

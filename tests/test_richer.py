"""Effects that set out from a special case of theirs, or from another start."""

import unittest

import numpy as np

from brace_drake.effects.registry import find_effect
from brace_drake.gap.candidates import fit_nominal
from brace_drake.gap.contenders import best_fits
from brace_drake.gap.ground import Ground
from brace_drake.gap.measures import misfit
from brace_drake.gap.richer import race_richer, richer_starts
from brace_drake.gap.screen import race
from tests.synthetic_bench import SyntheticBench

COULOMB, STRIBECK = (
    find_effect(f"{name}_friction") for name in ("coulomb", "stribeck")
)


class TestRicherStarts(unittest.TestCase):
    def test_they_are_as_strong_on_average_as_the_special_case(self):
        starts = list(richer_starts(STRIBECK, COULOMB, np.array([0.8])))
        self.assertEqual(len(starts), 6)
        for level, added, _ in starts:
            self.assertAlmostEqual(level + 0.5 * added, 0.8)
            self.assertGreater(added, 0.0)
        self.assertEqual(len({speed for *_, speed in starts}), 3)

    def test_they_keep_within_the_limits(self):
        for start in richer_starts(STRIBECK, COULOMB, np.array([60.0])):
            self.assertTrue(np.all(start <= STRIBECK.upper))


class TestRicherRace(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()

    def race(self, card, values):
        """Of Coulomb friction alone, then of richer effects from there."""
        evaluator = self.bench.evaluator([(card, np.array(values))])
        ground = Ground(evaluator, fit_nominal(evaluator))
        runners = race(ground, [COULOMB])
        richer = race_richer(ground, runners, [COULOMB, STRIBECK])
        return evaluator, best_fits(runners)[0], best_fits(richer)

    def test_large_friction_that_falls_with_speed_is_found_from_coulombs(self):
        evaluator, plain, (found,) = self.race(STRIBECK, [0.8, 0.5, 0.002])
        self.assertEqual(found.name, "stribeck_friction")
        self.assertLess(
            misfit(evaluator, found), 0.3 * misfit(evaluator, plain)
        )
        self.assertAlmostEqual(found.values[0][0], 0.8, delta=0.08)

    def test_of_coulomb_friction_nothing_richer_is_searched(self):
        _, _, found = self.race(COULOMB, [0.8])
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()

"""A second effect that takes little, on the twin's own recordings."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from brace_drake.selection.search.small_second import try_small_second

from brace_drake.effects.registry import effects_for
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.linearisation import Linearisation
from tests.synthetic_bench import DEVICE, SyntheticBench

NULL = SimpleNamespace(least_gain=lambda freedom: 0.015)
DELAY = 4e-4


def quiet(what, share):
    """Progress that nobody reads."""


class TestSmallSecond(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench, cls.cards = SyntheticBench(), effects_for(DEVICE)

    def beside_bias(self, delay):
        """Second effects of a recording with a force bias and a delay."""
        bias = self.cards["force_bias"], np.array([0.4])
        late = self.cards["command_delay"], np.array([delay])
        evaluator = self.bench.evaluator([bias, late] if delay else [bias])
        leader = fit_effects(evaluator, [bias[0]], [bias[1]])
        names = "command_delay", "hardening", "hysteresis", "ring_mass"
        found = try_small_second(
            Linearisation(evaluator, leader),
            [self.cards[name] for name in names],
            Criterion(leader, evaluator.count, True, null=NULL),
            quiet,
        )
        return evaluator, leader, found

    def test_it_is_named_though_the_gap_is_at_the_floor_without_it(self):
        evaluator, leader, found = self.beside_bias(DELAY)
        self.assertLess(leader.excess / evaluator.count, 0.1)
        self.assertEqual(found[0].kinds, {"force_bias", "command_delay"})
        self.assertAlmostEqual(found[0].values[1][0], DELAY, delta=5e-5)

    def test_where_there_is_none_nothing_is_named(self):
        _, _, found = self.beside_bias(0.0)
        self.assertEqual(found, [])

    def test_beside_what_is_averaged_over_noise_nothing_is_looked_for(self):
        dry = self.cards["coulomb_friction"]
        evaluator = self.bench.evaluator([(dry, np.array([0.1]))])
        base = Linearisation(evaluator, fit_nominal(evaluator))
        base.base = replace(base.base, is_dithered=True)
        criterion = Criterion(base.base, evaluator.count, True, null=NULL)
        found = try_small_second(base, self.cards.values(), criterion, quiet)
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()

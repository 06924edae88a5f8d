"""What noise alone gives an effect, and what the twin's own errors do."""

import unittest
from types import SimpleNamespace

import numpy as np
from brace_drake.selection.null_bootstrap import NullDistribution

from brace_drake.selection.criterion import Criterion


def null(is_known=True, gain=0.001):
    return NullDistribution(np.zeros(9), np.full(9, gain), 0.0, is_known)


class TestLeastGain(unittest.TestCase):
    def test_effects_of_more_parameters_have_to_gain_more(self):
        found = [null().least_gain(n) for n in (1, 3, 4, 6, 36)]
        np.testing.assert_allclose(found, [0.016, 0.016, 0.021, 0.031, 0.031])

    def test_where_instruments_are_not_known_all_have_to_gain_as_much(self):
        for n in (1, 6):
            self.assertAlmostEqual(null(False).least_gain(n), 0.031)

    def test_what_noise_gives_comes_on_top(self):
        more = null(gain=0.011).least_gain(1) - null().least_gain(1)
        self.assertAlmostEqual(more, 0.01)

    def test_a_fit_is_held_to_the_parameters_that_it_has_more(self):
        def gain_is_more(taken, before, after):
            old = SimpleNamespace(excess=50.0, freedom=before)
            new = SimpleNamespace(excess=50.0 - 1000.0 * taken, freedom=after)
            return Criterion(old, 1000, True, null=null()).gains(new, old)

        self.assertTrue(gain_is_more(0.02, 6, 7))
        self.assertTrue(gain_is_more(0.02, 6, 6))
        self.assertFalse(gain_is_more(0.02, 1, 7))
        self.assertFalse(gain_is_more(0.015, 0, 1))


if __name__ == "__main__":
    unittest.main()

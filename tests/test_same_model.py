"""Rivals that have come down to the same model are no two explanations."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.effects.registry import all_effects
from brace_drake.selection.same_model import simpler_twin

CARDS = all_effects()


def fit(is_searched=True, **uses):
    return SimpleNamespace(
        is_searched=is_searched,
        uses=[(CARDS[k], np.array(v)) for k, v in uses.items()],
    )


COULOMB = fit(coulomb_friction=[3.0])
BIAS = [0.1] * len(CARDS["force_bias"].parameters)


class TestSameModel(unittest.TestCase):
    def test_stribeck_friction_without_breakaway_is_coulomb_friction(self):
        fallen = fit(stribeck_friction=[3.0, 0.0, 0.002])
        self.assertIs(simpler_twin(fallen, [fallen, COULOMB]), COULOMB)

    def test_with_breakaway_it_is_another_model(self):
        richer = fit(stribeck_friction=[3.0, 0.4, 0.002])
        self.assertIsNone(simpler_twin(richer, [richer, COULOMB]))

    def test_a_hundredth_of_a_large_friction_is_no_breakaway(self):
        large = fit(coulomb_friction=[60.0])
        for breakaway, same in ((0.5, large), (0.9, None)):
            with self.subTest(breakaway=breakaway):
                richer = fit(stribeck_friction=[60.0, breakaway, 0.002])
                self.assertIs(simpler_twin(richer, [richer, large]), same)

    def test_the_simpler_one_is_not_the_same_as_the_richer(self):
        fallen = fit(stribeck_friction=[3.0, 0.0, 0.002])
        self.assertIsNone(simpler_twin(COULOMB, [fallen, COULOMB]))

    def test_what_stands_beside_it_has_to_be_the_same(self):
        fallen = fit(stribeck_friction=[3.0, 0.0, 0.002], force_bias=BIAS)
        pair = fit(coulomb_friction=[3.0], force_bias=BIAS)
        self.assertIs(simpler_twin(fallen, [COULOMB, pair]), pair)

    def test_what_was_never_fitted_is_no_model(self):
        fallen = fit(stribeck_friction=[3.0, 0.0, 0.002])
        screened = fit(is_searched=False, coulomb_friction=[3.0])
        self.assertIsNone(simpler_twin(fallen, [screened]))


if __name__ == "__main__":
    unittest.main()

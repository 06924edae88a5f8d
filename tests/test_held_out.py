"""What fits leave on motions left out."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.held_out import held_out_misfit, motions_of
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from tests.synthetic_bench import RATE, SyntheticBench, record, residual_of


class TestHeldOut(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        bench, cls.card = SyntheticBench(), find_effect("force_bias")
        cls.twin, uses = bench.twin, [(cls.card, np.array([0.1]))]
        campaign = record(cls.twin, bench.subject, uses, 97)
        again = record(cls.twin, bench.subject, uses, 98)
        runs = [*campaign.runs]
        runs += [replace(r, file=f"again_{r.file}") for r in again.runs]
        floors, _ = estimate_floors(cls.twin, campaign, bench.subject, 0)
        prepared = prepare_runs(cls.twin, runs, floors, RATE, 0)
        cls.evaluator = Evaluator(cls.twin, prepared, 2)

    def test_it_is_what_a_fit_without_the_motion_leaves_on_it(self):
        fit = fit_effects(self.evaluator, [self.card], [np.array([0.05])])
        squares = 0.0
        for out in range(len(self.evaluator.prepared)):
            runs = list(self.evaluator.prepared)
            (left_out,) = runs[out : out + 1]
            others = Evaluator(self.twin, runs[:out] + runs[out + 1 :], 2)
            apart = fit_effects(others, [self.card], [np.array([0.05])])
            alone = Evaluator(self.twin, [left_out], 2)
            residual = residual_of(alone, apart.subject, apart.uses, "fine")
            squares += float(residual @ residual)
        expected = squares / self.evaluator.count - 1.0
        found = held_out_misfit(self.evaluator, fit)
        gain = expected - fit.excess / self.evaluator.count
        self.assertGreater(gain, 0.0)
        self.assertAlmostEqual(found, expected, delta=0.2 * gain)

    def test_useless_effects_take_something_where_fitted_and_not_elsewhere(
        self,
    ):
        fit = fit_effects(self.evaluator, [self.card], [np.array([0.05])])
        gained, foreseen = [], []
        for name in ("ring_mass", "force_gain", "viscous_leg", "force_scale"):
            other = find_effect(name)
            values = [fit.values[0], other.off()]
            both = fit_effects(self.evaluator, [self.card, other], values)
            gained.append(fit.excess - both.excess)
            foreseen.append(held_out_misfit(self.evaluator, both))
        self.assertGreater(np.mean(gained), 0.0)
        self.assertGreater(
            np.mean(foreseen), held_out_misfit(self.evaluator, fit)
        )

    def test_a_single_motion_tells_nothing(self):
        alone = Evaluator(self.twin, self.evaluator.prepared[1:2], 1)
        fit = fit_nominal(alone)
        self.assertIsNone(held_out_misfit(alone, fit))

    def test_repeats_are_left_out_together(self):
        files = ("push", None), ("again", "push"), ("stairs", None)
        runs = [
            SimpleNamespace(run=SimpleNamespace(file=f, repeat_of=r))
            for f, r in files
        ]
        self.assertEqual(motions_of(runs), [[0, 1], [2]])


if __name__ == "__main__":
    unittest.main()

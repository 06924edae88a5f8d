"""Decoys of equal freedom, and what fits leave on motions left out."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from brace_drake.selection.surrogate_data import (
    loses_to_surrogates,
    surrogate_gains,
)
from scipy.signal import lfilter

from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.held_out import held_out_misfit, motions_of
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.selection import thresholds
from tests.synthetic_bench import RATE, SyntheticBench, record, residual_of

SAMPLES, CHANNELS = 400, 3


class Recorded:
    """Two runs of unit weights: fits over them are made of arrays."""

    def __init__(self):
        bins = SAMPLES // 2
        weights = np.full((bins, CHANNELS), 1.0 / np.sqrt(SAMPLES / 2.0))
        run = SimpleNamespace(file="a.csv", repeat_of=None)
        self.prepared = [
            PreparedRun(
                run, None, np.zeros((SAMPLES, CHANNELS)), weights, None, 0, i
            )
            for i in range(2)
        ]
        self.ends = list(np.cumsum([p.num_weighted for p in self.prepared]))
        self.count = sum(p.count for p in self.prepared)

    def weigh(self, signals):
        """Columns of signals (2, SAMPLES, CHANNELS, n) as a residual has."""
        return np.column_stack(
            [
                np.concatenate(
                    [
                        p.weigh(signals[i, ..., k])
                        for i, p in enumerate(self.prepared)
                    ]
                )
                for k in range(signals.shape[-1])
            ]
        )

    def fit(self, columns, residual, num_subject=2):
        """A fit of these sensitivities that has left this residual."""
        return SimpleNamespace(
            subject=np.zeros(num_subject),
            solution=SimpleNamespace(jacobian=columns, residual=residual),
            excess=float(residual @ residual) - self.count,
        )


class TestDecoys(unittest.TestCase):
    def setUp(self):
        self.runs, self.rng = Recorded(), np.random.default_rng(5)
        self.subject = self.signals(2)

    def signals(self, n):
        noise = self.rng.standard_normal((2, SAMPLES, CHANNELS, n))
        return self.runs.weigh(lfilter([1.0], [1.0, -0.8], noise, axis=1))

    def take(self, effect, gap):
        """Fits before and after: the effect takes what it can of a gap."""
        before = self.runs.fit(self.subject, gap)
        columns = np.column_stack([self.subject, effect])
        step = np.linalg.lstsq(columns, gap, rcond=None)[0]
        return before, self.runs.fit(columns, gap - columns @ step)

    def noise(self):
        return self.rng.standard_normal(self.runs.ends[-1])

    def test_the_cause_of_a_gap_takes_by_far_more_than_its_decoys(self):
        effect = self.signals(1)
        before, after = self.take(effect, 3.0 * effect[:, 0] + self.noise())
        gains = surrogate_gains(self.runs, before, after, 0)
        self.assertEqual(len(gains), thresholds.NUM_SURROGATES)
        np.testing.assert_array_equal(gains, np.sort(gains))
        taken = (before.excess - after.excess) / self.runs.count
        self.assertGreater(taken, 3.0 * gains[-1])
        self.assertFalse(loses_to_surrogates(self.runs, before, after, 0))

    def test_an_effect_of_other_times_loses_to_its_decoys(self):
        lost = 0
        for _ in range(10):
            gap = 30.0 * self.signals(1)[:, 0] + self.noise()
            before, after = self.take(self.signals(1), gap)
            lost += loses_to_surrogates(self.runs, before, after, 0)
        self.assertGreaterEqual(lost, 9)

    def test_copies_of_a_constant_effect_tell_nothing(self):
        # Of a constant in two runs every second decoy is a copy.
        constant = np.ones((2, SAMPLES, CHANNELS, 1))
        effect = self.runs.weigh(constant)
        before, after = self.take(effect, 3.0 * effect[:, 0] + self.noise())
        gains = surrogate_gains(self.runs, before, after, 0)
        self.assertLess(len(gains), 0.7 * thresholds.NUM_SURROGATES)
        self.assertGreater(len(gains), 0.3 * thresholds.NUM_SURROGATES)
        self.assertFalse(loses_to_surrogates(self.runs, before, after, 0))

    def test_of_noise_each_parameter_of_a_decoy_takes_one_square(self):
        # Chi-squared of p degrees of freedom, whatever the columns are.
        for p in (1, 4):
            before, after = self.take(self.signals(p), self.noise())
            gains = surrogate_gains(self.runs, before, after, 1)
            mean = float(np.mean(gains)) * self.runs.count
            self.assertAlmostEqual(mean / p, 1.0, delta=0.45)

    def test_they_are_the_same_for_the_same_seed(self):
        before, after = self.take(self.signals(1), self.noise())
        first, again, other = (
            surrogate_gains(self.runs, before, after, s) for s in (3, 3, 4)
        )
        np.testing.assert_array_equal(first, again)
        self.assertFalse(np.array_equal(first, other))


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

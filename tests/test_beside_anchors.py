"""A second effect beside displaced anchors, on the twin's own recordings."""

import unittest
from dataclasses import replace

import numpy as np
from brace_drake.selection.search.joint_refit import (
    implausible,
    refit_with_second,
    replace_second,
)

from brace_drake.effects.registry import effects_for
from brace_drake.identification.fits import finish_fit
from brace_drake.identification.least_squares import LeastSquaresSolution
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.problem import CandidateProblem
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.search import search_causes
from tests.synthetic_bench import DEVICE, SyntheticBench, searched


def quiet(what, share):
    """Progress that nobody reads."""


class TestBesideAnchors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench, cls.cards = SyntheticBench(), effects_for(DEVICE)
        anchors, lag = cls.cards["anchor_error"], cls.cards["force_lag"]
        rng = np.random.default_rng(1)
        cls.displaced = 3e-4 * rng.standard_normal(36)
        uses = [(anchors, cls.displaced), (lag, np.array([0.02]))]
        cls.evaluator = cls.bench.evaluator(uses)
        nominal = fit_nominal(cls.evaluator)
        ground = Linearisation(cls.evaluator, nominal)
        cls.stray = searched(ground, [anchors], places=0)[0]

    def pair_with(self, second):
        """True anchors and another effect, as a search might leave them."""
        effects = [self.cards["anchor_error"], second]
        values = [self.displaced, second.starts()[0]]
        problem = CandidateProblem(self.evaluator, effects, values)
        z = problem.join(self.bench.subject, values)
        (residual,) = problem.batch([z])
        columns = problem.columns(z, base=residual)
        end = LeastSquaresSolution(z, residual, columns, 1, True)
        return replace(finish_fit(problem, end), refined=True)

    def test_the_second_effect_leads_anchors_back(self):
        names = "force_bias", "force_lag", "viscous_leg"
        cards = [self.cards[n] for n in names]
        self.assertGreater(self.stray.excess / self.evaluator.count, 1.0)
        self.assertEqual(implausible([self.stray]), [self.stray])
        best = refit_with_second(self.evaluator, self.stray, cards, quiet)[0]
        self.assertEqual(best.kinds, {"anchor_error", "force_lag"})
        self.assertLess(best.excess / self.evaluator.count, 0.1)
        self.assertAlmostEqual(best.values[1][0], 0.02, delta=0.002)

    def test_one_that_leaves_less_takes_the_place_of_a_second_effect(self):
        lag, delay = self.cards["force_lag"], self.cards["command_delay"]
        wrong = self.pair_with(delay)
        found = replace_second(self.evaluator, wrong, [lag], quiet)
        self.assertEqual([f.effects[-1].key for f in found], ["force_lag"])
        self.assertLess(found[0].excess / self.evaluator.count, 0.1)
        again = replace_second(self.evaluator, found[0], [delay], quiet)
        self.assertEqual(again, [])


class TestAnchorsInPlaceOfOthers(unittest.TestCase):
    def test_who_does_with_few_parameters_is_searched_beside_anchors(self):
        bench, card = SyntheticBench(), effects_for(DEVICE)["weak_leg"]
        evaluator, nominal = bench.recording_with_a_gap(card)
        fits, *_ = search_causes(evaluator, nominal, 0, quiet, False)
        found = {f.name: f for f in fits}
        self.assertIn("anchor_error", found)
        self.assertTrue(found["weak_leg"].refined)
        self.assertLess(found["weak_leg"].excess / evaluator.count, 0.1)


if __name__ == "__main__":
    unittest.main()

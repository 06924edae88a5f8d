"""A recording with any effect of the library leads back to that effect."""

import math
import unittest
from functools import cache

import numpy as np

from brace_drake.design.confusable import ALIKE
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.registry import effects_for
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.laws.hooks import plug
from brace_drake.selection.decision import decide
from brace_drake.selection.level import make_criterion
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import (
    predict,
    screen,
    search_best,
    silent,
)
from brace_drake.selection.search.search import search_causes
from brace_drake.selection.search.shortlist import best_fits
from brace_drake.selection.settle import settle
from tests.synthetic_bench import DEVICE, SyntheticBench, without_torso


@plug("torso")
def _shake(t, dt, p_T, r_T, V, law, F, p, x):
    F[4] += p[0] * math.sin(2.0 * math.pi * 6.0 * t)


TREMOR = Effect(
    name="tremor",
    block="torso",
    title="a trembling torso",
    equation="f = A sin(2 pi 6 Hz t)",
    source="none: unknown to the library",
    parameters=(EffectParameter("amplitude_N", "N", 0.0, 10.0, (0.3,), "A"),),
    laws={"torso": _shake},
    signature="a line in the spectrum",
    impostors={},
    experiment="quiet hold",
)


def answer(evaluator):
    """The verdict over all causes."""
    criterion = make_criterion(evaluator, fit_nominal(evaluator), ())
    fits = search_causes(evaluator, criterion, silent)
    return decide(*settle(evaluator, criterion, fits))


@cache
def make_bench():
    """The bench of all classes here."""
    return SyntheticBench()


class OnTheBench(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = make_bench()
        cls.cards = effects_for(DEVICE)


class TestRegistry(OnTheBench):
    def check(self, card, sign=1.0):
        """A search among an effect's impostors ends with the effect."""
        names = {card.name, *card.impostors}
        rivals = [c for c in self.cards.values() if c.name in names]
        simple = [c for c in rivals if not c.is_flexible]
        evaluator, nominal = self.bench.recording_with_a_gap(card, sign)
        ground = Linearisation(evaluator, nominal)
        runners = screen(ground, simple)
        search_best(ground, runners)
        if card.is_flexible:
            many = screen(ground, [card])
            search_best(ground, many, places=0)
            runners += many
        best = best_fits(runners)[0]
        self.assertLess(best.excess, 0.3 * nominal.excess)
        found = frozenset((card.name, *best.identifiers))
        told = found == {card.name} or found in ALIKE
        self.assertTrue(told, sorted(found))

    def test_every_effect_leads_back_to_itself_among_its_impostors(self):
        for key, card in self.cards.items():
            with self.subTest(effect=key):
                self.check(card)

    def test_an_effect_of_the_other_sign_leads_back_to_itself_too(self):
        for name in ("posture_drift", "force_scale", "force_bias"):
            with self.subTest(effect=name):
                self.check(self.cards[name], -1.0)


class TestAnswers(OnTheBench):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.of_none = answer(cls.bench.evaluator(()))

    def test_no_effect_leads_to_none(self):
        self.assertFalse(self.of_none.gap)

    def test_without_the_torsos_marker_no_answer_is_surer(self):
        delay = self.cards["command_delay"]
        late = [(delay, self.bench.values_of_a_gap(delay))]
        for uses, whole in (
            ((), self.of_none),
            (late, answer(self.bench.evaluator(late))),
        ):
            part = answer(self.bench.evaluator(uses, without_torso))
            self.assertEqual(part.gap, whole.gap)
            self.assertLess(part.probability, whole.probability)

    def test_two_effects_at_once_lead_back_to_both(self):
        names = "command_delay", "force_bias"
        cards = [self.cards[n] for n in names]
        uses = [(c, self.bench.values_of_a_gap(c)) for c in cards]
        verdict = answer(self.bench.evaluator(uses))
        self.assertEqual(set(verdict.effects), set(names))

    def test_one_of_few_parameters_is_named_before_one_of_dozens(self):
        evaluator, _ = self.bench.recording_with_a_gap(self.cards["weak_leg"])
        verdict = answer(evaluator)
        self.assertEqual(verdict.effects, ("weak_leg",))
        self.assertFalse(verdict.outside_library)

    def test_what_a_straight_way_hides_is_searched_as_a_second_effect(self):
        bias, reflex = self.cards["force_bias"], self.cards["reflex"]
        both = np.array([0.4]), np.array([400.0, 30.0, 0.08])
        uses = list(zip((bias, reflex), both, strict=True))
        evaluator = self.bench.evaluator(uses)
        leader = fit_effects(evaluator, [bias], both[:1])
        ground, bar = Linearisation(evaluator, leader), 0.6 * leader.excess
        promises = [r.predicted for r in predict(ground, reflex)]
        self.assertGreater(min(promises), bar)
        found = screen(ground, [reflex])
        search_best(ground, found)
        self.assertLess(best_fits(found)[0].excess, bar)

    def test_what_no_effect_explains_is_outside_the_library(self):
        verdict = answer(self.bench.evaluator([(TREMOR, np.array([0.6]))]))
        self.assertTrue(verdict.gap and verdict.outside_library)


if __name__ == "__main__":
    unittest.main()

"""A recording with any effect of the library leads back to that effect."""

import unittest

from brace_drake.effects.registry import effects_for
from brace_drake.gap.alike import ALIKE
from brace_drake.gap.candidates import fit_nominal
from brace_drake.gap.causes import try_causes
from brace_drake.gap.contenders import best_fits
from brace_drake.gap.ground import Ground
from brace_drake.gap.screen import race
from brace_drake.gap.verdict import decide
from tests.synthetic_bench import DEVICE, SyntheticBench


def answer(evaluator):
    """The verdict over all causes."""
    nominal = fit_nominal(evaluator)
    fits, null = try_causes(evaluator, nominal, 0, lambda what, share: None)
    return decide(evaluator, nominal, fits, null)


class TestRegistry(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        cls.cards = effects_for(DEVICE)

    def check(self, card, sign=1.0):
        """A search among an effect's impostors ends with the effect."""
        names = {card.name, *card.impostors}
        rivals = [c for c in self.cards.values() if c.name in names]
        simple = [c for c in rivals if not c.is_flexible]
        values = self.bench.values_of_a_gap(card, sign)
        evaluator = self.bench.evaluator([(card, values)])
        nominal = fit_nominal(evaluator)
        ground = Ground(evaluator, nominal)
        runners = race(ground, simple)
        if card.is_flexible:
            runners += race(ground, [card], places=0)
        best = best_fits(runners)[0]
        self.assertLess(best.excess, 0.3 * nominal.excess)
        found = frozenset((card.name, *best.identifiers))
        told = found == {card.name} or found in ALIKE
        self.assertTrue(told, sorted(found))

    def test_no_effect_leads_to_none(self):
        self.assertFalse(answer(self.bench.evaluator(())).gap)

    def test_every_effect_leads_back_to_itself_among_its_impostors(self):
        for key, card in self.cards.items():
            with self.subTest(effect=key):
                self.check(card)

    def test_an_effect_of_the_other_sign_leads_back_to_itself_too(self):
        for name in ("posture_drift", "force_scale", "force_bias"):
            with self.subTest(effect=name):
                self.check(self.cards[name], -1.0)

    def test_two_effects_at_once_lead_back_to_both(self):
        for names in (
            ("command_delay", "force_bias"),
            ("ring_mass", "breathing"),
        ):
            cards = [self.cards[n] for n in names]
            uses = [(c, self.bench.values_of_a_gap(c)) for c in cards]
            with self.subTest(effects=names):
                verdict = answer(self.bench.evaluator(uses))
                self.assertEqual(set(verdict.winner.identifiers), set(names))


if __name__ == "__main__":
    unittest.main()

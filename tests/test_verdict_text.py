"""The verdict's sentence, as it may stand in a paper."""

import unittest

from brace_drake.document.verdict_text import verdict_sentence
from brace_drake.effects.registry import find_effect


def row(name, unit, value):
    return {"name": name, "unit": unit, "value": value}


def sentence(rows, *names, closed=None):
    cards = [find_effect(name) for name in names]
    return verdict_sentence("case016", cards, True, closed, rows)


CLEARANCE = (row("pad", "1", 0.0), row("clearance_m", "m", 0.0020328))


class TestVerdictText(unittest.TestCase):
    def test_two_effects_have_each_their_own_numbers_with_units(self):
        rows = [*CLEARANCE, row("extra_viscous_N_s_m", "N s/m", 99.458)]
        self.assertEqual(
            sentence(rows, "clearance", "viscous_leg", closed=1.0001),
            "The gap in case016 is explained by clearance between pad and"
            " torso (both pads, clearance 2.033 mm) and viscous friction of"
            " the legs off its data sheet value (extra viscous 99.46 N s/m);"
            " adding them closes 100 % of the gap on the validation runs.",
        )

    def test_no_identifier_and_one_meaning_of_the_word_gap(self):
        text = sentence(CLEARANCE, "clearance", closed=0.9957)
        self.assertNotIn("_", text)
        self.assertIn("adding it closes 99.6 % of the gap", text)
        self.assertEqual(text.count("gap"), 2)

    def test_of_parameters_drawn_alike_there_is_their_deviation(self):
        rows = [row("anchor_m", "m", 0.0021), *CLEARANCE]
        text = sentence(rows, "anchor_error", "clearance")
        self.assertIn("(anchor 2.1 mm)", text)
        self.assertIn("(both pads, clearance 2.033 mm).", text)

    def test_nearly_all_is_not_all(self):
        text = sentence(CLEARANCE, "clearance", closed=0.99991)
        self.assertIn("closes more than 99.9 %", text)


if __name__ == "__main__":
    unittest.main()

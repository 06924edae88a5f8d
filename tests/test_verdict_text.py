"""The verdict's sentence, as it may stand in a paper."""

import unittest
from types import SimpleNamespace

from brace_drake.document.verdict_text import (
    controller_text,
    stated_text,
    verdict_sentence,
)
from brace_drake.effects.registry import find_effect


def row(name, unit, value):
    return {"name": name, "unit": unit, "value": value}


CLEARANCE = (row("pad", "1", 0.0), row("clearance_m", "m", 0.0020328))
VISCOUS = (row("extra_viscous_N_s_m", "N s/m", 99.458),)
ANCHORS = (row("anchor_m", "m", 0.0021),)


def verdict(**effects):
    """Of effects with the rows of their parameters."""
    return {
        "gap": True,
        "effects": list(effects),
        "supported": [
            {
                "effect": name,
                "title": find_effect(name).title,
                "probability": 0.97,
                "closes": 0.5,
                "parameters": rows,
            }
            for name, rows in effects.items()
        ],
        "unexplained": {"share": 0.0, "block": None, "description": ""},
        "outside_library": False,
        "ambiguous_with": [],
        "contradicted": None,
    }


MOVED = [
    {"name": "ring_mass_kg", "unit": "kg", "value": 0.018, "deviations": 1.2}
]
SCALE_OFF = {
    "name": "force_scale", "unit": "1", "value": -0.0325, "deviations": -5.42
}  # fmt: skip


def sentence(told, closed=None, moved=(), off=None):
    return verdict_sentence("case016", told, closed, moved, off)


class TestVerdictText(unittest.TestCase):
    def test_two_effects_have_each_their_own_numbers_with_units(self):
        told = verdict(clearance=CLEARANCE, viscous_leg=VISCOUS)
        self.assertEqual(
            sentence(told, closed=1.0001),
            "The gap in case016 is explained by clearance between pad and"
            " torso (both pads, clearance 2.033 mm) and viscous friction of"
            " the legs off its data sheet value (extra viscous 99.46 N s/m);"
            " adding them closes 100 % of the gap on the validation runs.",
        )

    def test_a_twin_above_its_noise_is_not_said_to_be_at_it(self):
        none = verdict() | {"gap": False}
        told = sentence(none, moved=MOVED, off=1.96)
        self.assertIn("is 1.96 times the noise floor off", told)
        self.assertIn("numbers within their tolerances", told)
        self.assertNotIn("down to its noise", told)
        self.assertTrue(told.startswith("No gap"))
        self.assertIn(
            "down to its noise", sentence(none, moved=MOVED, off=1.02)
        )

    def test_no_identifier_and_one_meaning_of_the_word_gap(self):
        text = sentence(verdict(clearance=CLEARANCE), closed=0.9957)
        self.assertNotIn("_", text)
        self.assertIn("adding it closes 99.6 % of the gap", text)
        self.assertEqual(text.count("gap"), 2)

    def test_of_parameters_drawn_alike_there_is_their_deviation(self):
        text = sentence(verdict(anchor_error=ANCHORS, clearance=CLEARANCE))
        self.assertIn("(anchor 2.1 mm)", text)
        self.assertIn("(both pads, clearance 2.033 mm);", text)

    def test_nearly_all_is_not_all(self):
        text = sentence(verdict(clearance=CLEARANCE), closed=0.99991)
        self.assertIn("closes more than 99.9 %", text)

    def test_what_is_certain_stands_before_what_is_left(self):
        told = verdict(clearance=CLEARANCE) | {"outside_library": True}
        told["unexplained"] = {
            "share": 0.31,
            "block": "actuation",
            "description": "goes with the speed, as a damper would",
        }
        self.assertEqual(
            sentence(told),
            "Clearance between pad and torso (both pads, clearance 2.033 mm)"
            " is there (p 0.97) and explains 50.0 % of the gap in case016;"
            " 31.0 % is left, in actuation, and goes with the speed, as a"
            " damper would.",
        )

    def test_what_is_withdrawn_by_itself_stands_behind_what_stays(self):
        told = verdict(clearance=CLEARANCE) | {"contradicted": "it is worse"}
        text = sentence(told, closed=0.9)
        self.assertTrue(text.startswith("The gap in case016 is explained by"))
        self.assertTrue(text.endswith("runs. Withdrawn: it is worse."))

    def test_effects_that_close_a_part_explain_no_more_than_that(self):
        text = sentence(verdict(clearance=CLEARANCE), closed=0.44)
        self.assertTrue(text.startswith("The gap in case016 is partly"))
        self.assertIn("adding it closes 44.0 % of the gap", text)

    def test_a_number_beyond_its_tolerance_is_told_with_and_without_a_gap(self):
        far = [*MOVED, SCALE_OFF]
        told = "force scale is off by -3.2 %, 5.4 of its tolerances."
        none = verdict() | {"gap": False}
        text = sentence(none, moved=far, off=1.2)
        self.assertTrue(text.endswith(told), text)
        self.assertIn("more than tolerances allow", text)
        self.assertNotIn("ring mass", text)
        text = sentence(verdict(clearance=CLEARANCE), closed=0.9, moved=far)
        self.assertTrue(text.endswith(f"Beside them {told}"), text)
        text = sentence(none, moved=MOVED, off=1.2)
        self.assertIn("No gap that tolerances do not allow for", text)

    def test_a_rival_that_cannot_be_told_apart_is_in_the_sentence(self):
        told = verdict(clearance=CLEARANCE)
        told["ambiguous_with"] = ["viscous_leg+force_bias"]
        self.assertIn(
            f", or as well by {find_effect('viscous_leg').title} and"
            f" {find_effect('force_bias').title}, which these runs cannot",
            sentence(told, closed=0.9),
        )

    def test_without_validation_runs_nothing_is_confirmed(self):
        text = sentence(verdict(clearance=CLEARANCE))
        self.assertTrue(text.endswith("; no validation run confirms it."))

    def test_where_all_is_withdrawn_nothing_is_confirmed(self):
        told = verdict() | {"contradicted": "it is worse"}
        self.assertEqual(
            sentence(told),
            "There is a gap in case016, and nothing that explains it is"
            " confirmed: it is worse.",
        )

    def test_a_controller_that_does_not_follow_its_law_is_told(self):
        row = {"block": "controller", "normalised_rms": 6184.2}
        text = controller_text([row | {"acquitted": False}])
        self.assertIn("6.18e+03 times their floor", text)
        self.assertIn("between controller and drive", text)
        self.assertEqual(controller_text([row | {"acquitted": True}]), "")

    def test_a_machine_that_is_not_as_stated_is_told(self):
        mass = SimpleNamespace(name="mass_kg_m2", value=3.0, standard_error=0.1)
        damper = SimpleNamespace(
            name="viscous_N_s_m", value=41.0, standard_error=0.1
        )
        stated = {"mass_kg": 2.0, "viscous_N_s_m": 40.0}
        self.assertEqual(
            stated_text(stated, [mass, damper]),
            " Fitted anew, it has mass 1.5 times what was stated.",
        )
        self.assertEqual(stated_text({"mass_kg": 2.9}, [mass]), "")


if __name__ == "__main__":
    unittest.main()

"""What is searched and fitted: chosen by a caller, or by a scenario's file."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

from brace_drake.core.errors import EffectError, FitError, ScenarioError
from brace_drake.devices.choice import Choice
from brace_drake.devices.nominal_scenario import parse_choice
from brace_drake.devices.subject import SubjectParameter
from brace_drake.effects.registry import effects_for
from brace_drake.results.options import split_names

STIFFNESS = SubjectParameter("stiffness_N_m", "N/m", 100.0, 70.0, 150.0)
OFFSET = SubjectParameter("offset_m", "m", 0.0, -0.1, 0.1, scale=0.01)
BENCH = "bench stage 2"


def twin():
    """Two parameters of a subject, and the library of the bench."""
    return SimpleNamespace(
        subject=(STIFFNESS, OFFSET),
        device=BENCH,
        effects=lambda: effects_for(BENCH),
    )


def limited(**choice):
    """The parameters as a choice leaves them."""
    made = twin()
    Choice(**choice).limit_subject(made)
    return made.subject


class TestSubject(unittest.TestCase):
    def test_without_a_choice_nothing_changes(self):
        self.assertEqual(limited(), (STIFFNESS, OFFSET))

    def test_what_is_held_has_its_value_for_limits(self):
        held, free = limited(fixed={"stiffness_N_m": 400.0})
        self.assertEqual((held.lower, held.nominal, held.upper), (400.0,) * 3)
        self.assertTrue(held.is_fixed)
        self.assertEqual(free, OFFSET)

    def test_a_thousand_times_the_scenarios_value_is_the_most(self):
        for value in (0.1, 1e5):
            held, _ = limited(fixed={"stiffness_N_m": value})
            self.assertEqual(held.nominal, value)
            with self.assertRaises(FitError):
                far = value * (0.999 if value < 1.0 else 1.001)
                limited(fixed={"stiffness_N_m": far})

    def test_its_own_limits_are_always_allowed(self):
        wide = replace(OFFSET, name="gain", lower=1e-9, nominal=1e-9, upper=1e3)
        for value in (None, 1e-9, 1e3):
            made = twin()
            made.subject = (STIFFNESS, wide)
            Choice(fixed={"gain": value}).limit_subject(made)
            self.assertTrue(made.subject[1].is_fixed)

    def test_what_is_held_at_zero_keeps_its_unit(self):
        _, held = limited(fixed={"offset_m": None})
        self.assertEqual((held.nominal, held.unit_step), (0.0, 0.01))

    def test_what_is_not_free_is_held_at_the_scenarios_value(self):
        held, free = limited(free=("offset_m",))
        self.assertEqual((held.lower, held.upper), (100.0, 100.0))
        self.assertFalse(free.is_fixed)

    def test_bounds_may_be_wider_and_the_start_lies_within(self):
        own, _ = limited(bounds={"stiffness_N_m": (200.0, 900.0)})
        self.assertEqual((own.lower, own.nominal, own.upper), (200, 200, 900))
        self.assertEqual(own.unit_step, 100.0)

    def test_a_prior_moves_the_start_and_has_its_tolerance(self):
        known, other = limited(priors={"stiffness_N_m": (120.0, 8.0)})
        self.assertEqual((known.nominal, known.deviation), (120.0, 8.0))
        self.assertEqual(known.unit_step, 100.0)
        self.assertEqual(other, OFFSET)

    def test_a_prior_that_the_runs_contradict_is_told(self):
        choice = Choice(priors={"stiffness_N_m": (120.0, 8.0)})
        self.assertEqual(choice.contradicted({"stiffness_N_m": 140.0}), [])
        (told,) = choice.contradicted({"stiffness_N_m": 152.0})
        self.assertIn("4.0 standard deviations", told)

    def test_what_cannot_be_is_refused(self):
        name = "stiffness_N_m"
        for words, choice in (
            ("did you mean stiffness_N_m", {"free": ("stifness_N_m",)}),
            ("above 0 N/m", {"fixed": {name: -1.0}}),
            ("above 0 N/m", {"bounds": {name: (0.0, 5.0)}}),
            ("above 0 N/m", {"fixed": {name: float("nan")}}),
            ("a finite number", {"fixed": {"offset_m": float("inf")}}),
            (r"from 0.1 to 100000", {"fixed": {name: 1e300}}),
            (r"value is 1e-300; allowed: above 0 N/m, from 0.1 to 100000",
             {"fixed": {name: 1e-300}}),
            ("upper bound is 1e\\+06", {"bounds": {name: (50.0, 1e6)}}),
            ("from -10 to 10", {"fixed": {"offset_m": 11.0}}),
            ("the lower one first", {"bounds": {name: (5.0, 5.0)}}),
            ("held, and has bounds",
             {"fixed": {name: None}, "bounds": {name: (1.0, 2.0)}}),
            ("held, and has a prior",
             {"fixed": {name: None}, "priors": {name: (100.0, 2.0)}}),
            ("70 to 150 N/m", {"priors": {name: (200.0, 2.0)}}),
            ("above 0 N/m", {"priors": {name: (100.0, 0.0)}}),
            ("held, and free", {"fixed": {name: None}, "free": (name,)}),
            ("none is fitted", {"fixed": {name: None, "offset_m": None}}),
        ):  # fmt: skip
            with self.subTest(words=words):
                with self.assertRaisesRegex(FitError, words):
                    limited(**choice)

    def test_a_callers_choice_goes_over_that_of_a_file(self):
        file = Choice(
            fixed={"a": 1.0, "b": 2.0}, bounds={"c": (0.0, 1.0)}, free=("d",)
        )
        file = replace(file, priors={"c": (0.5, 0.1), "d": (1.0, 0.1)})
        mine = Choice(bounds={"a": (3.0, 4.0)}, fixed={"c": None})
        both = mine.over(file)
        self.assertEqual(both.priors, {"d": (1.0, 0.1)})
        self.assertEqual(both.fixed, {"b": 2.0, "c": None})
        self.assertEqual(both.bounds, {"a": (3.0, 4.0)})
        self.assertEqual(both.free, ("d",))


class TestEffects(unittest.TestCase):
    def keys(self, **choice):
        return {e.key for e in Choice(**choice).effects_of(twin())}

    def test_without_a_choice_all_are_searched(self):
        self.assertEqual(self.keys(), set(effects_for(BENCH)))

    def test_a_name_stands_for_all_of_its_forms_and_a_key_for_one(self):
        self.assertEqual(
            self.keys(effects=("backlash",)),
            {
                "backlash (play)",
                "backlash (gap)",
                "backlash (gap, dry friction)",
            },
        )
        self.assertEqual(
            self.keys(effects=split_names("backlash (gap, dry friction)")),
            {"backlash (gap, dry friction)"},
        )

    def test_what_is_left_out_is_not_searched(self):
        left = self.keys(without=("hysteresis", "saturation (drive)"))
        gone = set(effects_for(BENCH)) - left
        self.assertEqual(
            {k.split(" ")[0] for k in gone} - {"hysteresis"}, {"saturation"}
        )
        self.assertIn("saturation (command)", left)

    def test_a_parameter_of_an_effect_is_bounded_and_starts_within(self):
        bounds = {"coulomb_friction.coulomb_N": (1.0, 2.0)}
        cards = Choice(bounds=bounds).effects_of(twin())
        mine = [c for c in cards if c.name == "coulomb_friction"]
        self.assertTrue(mine)
        for card in mine:
            self.assertEqual((card.lower[0], card.upper[0]), (1.0, 2.0))
            self.assertEqual(card.parameters[0].starts, (1.5,))
        others = [c for c in cards if c.name != "coulomb_friction"]
        known = effects_for(BENCH)
        self.assertTrue(all(c is known[c.key] for c in others))

    def test_bounds_that_no_effect_has_are_refused(self):
        for words, name, bounds in (
            ("did you mean coulomb_N", "coulomb_friction.columb_N", (0, 1)),
            ("did you mean coulomb_friction", "coulomb.coulomb_N", (0, 1)),
            ("within 0 to 60 N", "coulomb_friction.coulomb_N", (-1, 1)),
            ("the lower one first", "coulomb_friction.coulomb_N", (2, 1)),
            ("no continuous number", "weak_leg.leg", (1, 2)),
        ):
            with self.subTest(words=words):
                with self.assertRaisesRegex(EffectError, words):
                    self.keys(bounds={name: bounds})

    def test_unknown_names_and_an_empty_search_are_refused(self):
        with self.assertRaisesRegex(EffectError, "did you mean hysteresis"):
            self.keys(without=("hysteresys",))
        with self.assertRaisesRegex(EffectError, "no effect is left"):
            self.keys(effects=("hysteresis",), without=("hysteresis",))


class TestWords(unittest.TestCase):
    def test_commas_within_parentheses_part_no_names(self):
        self.assertEqual(split_names(" a, b (c, d) ,e"), ("a", "b (c, d)", "e"))
        self.assertEqual(split_names(""), ())
        self.assertEqual(split_names("a (b"), ("a (b",))

    def test_a_scenarios_block_is_read(self):
        data = {
            "free": ["a"],
            "fixed": {"b": 1, "c": None},
            "bounds": {"d": [0, 1.5]},
            "priors": {"e": {"value": 2, "tolerance": 0.5}},
        }
        found = parse_choice(data, "s.yaml")
        self.assertEqual(found.free, ("a",))
        self.assertEqual(found.fixed, {"b": 1.0, "c": None})
        self.assertEqual(found.bounds, {"d": (0.0, 1.5)})
        self.assertEqual(found.priors, {"e": (2.0, 0.5)})

    def test_what_the_block_cannot_hold_is_told_with_file_and_key(self):
        for key, value, allowed in (
            ("", 3, "a map of keys"),
            ("free", "a", "a list of names"),
            ("fixed", {"a": "x"}, "a map of numbers"),
            ("fixed", {"a": True}, "a map of numbers"),
            ("bounds", {"a": [1.0]}, r"a map of \[lower, upper\]"),
            ("priors", {"a": {"value": 1.0}}, "a map of {value: NUMBER"),
        ):
            data = {key: value} if key else value
            with self.subTest(key=key):
                with self.assertRaisesRegex(
                    ScenarioError, rf"s.yaml: estimation.*allowed: {allowed}"
                ):
                    parse_choice(data, "s.yaml")
        with self.assertRaisesRegex(ScenarioError, "did you mean bounds"):
            parse_choice({"bound": {}}, "s.yaml")


if __name__ == "__main__":
    unittest.main()

"""Terms of the dictionary against functions by hand, and as cards."""

import math
import unittest

import numpy as np

from brace_drake.effects.registry import all_effects
from brace_drake.effects.unknown import (
    describe_term,
    is_term,
    terms,
    terms_for,
)
from brace_drake.effects.unknown.forms import CODE
from brace_drake.scenario.brace import BenchScenario, EffectUse
from brace_drake.scenario.effects import describe_use, scenario_uses
from brace_drake.scenario.load import CheckScenario

DEVICE = "bench stage 2"


def value(code, a=1.0, b=0.0, q=0.0, v=0.0, u=0.0, t=0.0, dt=1e-3, x=None):
    x = np.zeros(1) if x is None else x
    term, x[0] = terms.term_value(code, a, b, q, v, u, t, t / 10.0, dt, x[0])
    return term


class TestTerms(unittest.TestCase):
    def test_terms_of_place_and_speed_are_their_formulas(self):
        q, v, a = -0.7, 0.4, 0.3
        expected = {
            terms.SPRING: q,
            terms.EVEN: q**2,
            terms.CUBIC: q**3,
            terms.ABOVE: 0.0,
            terms.BELOW: a - q,
            terms.RIPPLE: math.sin(2 * math.pi * q / a),
            terms.VISCOUS: v,
            terms.DRAG: v**2,
            terms.EVEN_SPEED: abs(v),
            terms.DIRECTION: math.tanh(v / a),
            terms.PLACE_SPEED: q * v,
        }
        for code, known in expected.items():
            with self.subTest(code=code):
                self.assertAlmostEqual(value(code, a=a, q=q, v=v), known)

    def test_terms_of_load_are_their_formulas(self):
        self.assertAlmostEqual(value(terms.LOAD_SQUARE, u=-3.0), -9.0)
        self.assertAlmostEqual(value(terms.LOAD_EVEN, u=-3.0), 3.0)
        self.assertAlmostEqual(value(terms.LOAD_DIRECTION, u=-3, v=-9), -3.0)

    def test_an_arm_that_is_held_relaxes_with_its_time(self):
        x, dt, time = np.zeros(1), 1e-3, 0.5
        for _ in range(500):
            force = value(terms.MEMORY, a=time, q=1.0, dt=dt, x=x)
        self.assertAlmostEqual(force, math.exp(-1.0), places=6)

    def test_a_loop_takes_twice_its_force_times_the_way(self):
        # Dahl's loop over a way much longer than its width loses, in a cycle,
        # 4 F (s - O(width)).
        x, dt, width, s = np.zeros(1), 1e-4, 0.01, 1.0
        work = 0.0
        t = np.arange(0.0, 4.0, dt)
        for now in t:
            v = s * math.pi * math.cos(math.pi * now)
            force = value(terms.LOOP, a=width, v=v, dt=dt, x=x)
            if now >= 2.0:
                work += force * v * dt
        self.assertAlmostEqual(work, 4.0 * s, delta=6.0 * width)

    def test_a_pulse_has_the_area_of_its_length(self):
        t = np.arange(0.0, 10.0, 1e-3)
        area = sum(value(terms.PULSE, a=3.0, b=2.0, t=s) for s in t) * 1e-3
        self.assertAlmostEqual(area, 2.0, places=3)


class TestDictionary(unittest.TestCase):
    def test_no_term_is_a_cause_of_the_library(self):
        self.assertFalse([n for n in terms_for(DEVICE) if n in all_effects()])
        self.assertFalse(any(map(is_term, all_effects().values())))

    def test_strengths_and_onsets_are_told_in_units_of_the_place(self):
        card = terms_for(DEVICE)["term_ring_y_below"]
        # 2 N where y is 5 mm beyond the onset of -0.4 times 5 mm.
        values = np.array([2.0, -0.4, 0.0, float(terms.BELOW)])
        told = describe_term(card, values, np.array([0.1, 0.01, 0, 0]))
        force, onset = told["parameters"]
        self.assertEqual(force["unit"], "N/m")
        self.assertAlmostEqual(force["value"], 400.0)
        self.assertAlmostEqual(force["standard_error"], 20.0)
        self.assertAlmostEqual(onset["value"], -2e-3)
        self.assertIn("400 N/m, where y is below -2 mm", told["text"])

    def test_units_are_powers_of_their_parts(self):
        told = {
            name: describe_term(card, card.starts()[0], np.zeros(4))
            for name, card in terms_for(DEVICE).items()
            if name.startswith("term_legs_")
        }
        units = {row["parameters"][0]["unit"] for row in told.values()}
        # A drag goes with the square of the speed.
        self.assertIn("N s2/m2", units)
        self.assertIn("N s/m", units)

    def test_a_scenario_carries_a_term_as_it_does_an_effect(self):
        card = terms_for(DEVICE)["term_legs_ripple"]
        values = np.array([0.1, 0.3, 1.0, float(terms.RIPPLE)])
        scenario = BenchScenario(effects=[describe_use(card, values)])
        CheckScenario(scenario, "here")
        ((found, read),) = scenario_uses(scenario)
        self.assertEqual(found.name, card.name)
        np.testing.assert_array_equal(read, values)

    def test_another_form_than_its_name_says_is_refused(self):
        card = terms_for(DEVICE)["term_legs_ripple"]
        use = describe_use(card, np.array([0.1, 0.3, 1.0, 5.0]))
        wrong = EffectUse(use.name, {**use.parameters, CODE: 2.0}, use.form)
        with self.assertRaisesRegex(Exception, CODE):
            CheckScenario(BenchScenario(effects=[wrong]), "here")


if __name__ == "__main__":
    unittest.main()

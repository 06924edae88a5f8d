"""What the library does not know gets a law; noise gets none."""

import math
import unittest
from types import SimpleNamespace
from unittest import mock

import numpy as np

from brace_drake.discrepancy.search import search_law
from brace_drake.discrepancy.starts import residual_peaks
from brace_drake.document.law_rows import law_row, law_sentence
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.unknown import describe_term, terms_for
from brace_drake.identification.intervals import ParameterEstimate
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.isolation.repair_shares import share_repairs
from brace_drake.isolation.shapley import UNEXPLAINED as NONE
from brace_drake.laws.hooks import plug
from brace_drake.report.page import render_page
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.level import make_criterion
from tests.diagnoses import make_partly
from tests.synthetic_bench import DEVICE, SyntheticBench

BLOCKS = {"ring": "mechanism", "torso": "torso", "drive": "actuation"}
STIFFNESS, ONSET, SMOOTH = 600.0, -1.5e-3, 1e-4


@plug("ring")
def _pull(t, dt, p_R, r_R, V, F, p, x):
    # A cable that tightens softly: a one-sided spring in the limit.
    slack = (p_R[1] - p[1]) / p[2]
    F[4] += p[0] * p[2] * math.log1p(math.exp(-slack))


@plug("torso")
def _shake(t, dt, p_T, r_T, V, law, F, p, x):
    F[4] += p[0] * math.sin(2.0 * math.pi * 3.1 * t + 0.7)


@plug("drive")
def _cog(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    for k in range(f.shape[0]):
        f[k] += p[0] * math.sin(2.0 * math.pi * l[k] / p[1])


def _foreign(name, point, law, *names):
    parameters = tuple(
        EffectParameter(n, "1", -1e6, 1e6, (1.0,), n) for n in names
    )
    return Effect(
        name=name,
        block=BLOCKS[point],
        title=name,
        equation=name,
        source="none: unknown to the library",
        parameters=parameters,
        laws={point: law},
        signature="",
        impostors={},
        experiment="",
    )


CABLE = _foreign("cable", "ring", _pull, "k", "y0", "s")
COGGING = _foreign("screw", "drive", _cog, "A", "pitch")
TREMOR = _foreign("tremor", "torso", _shake, "A")


class TestSearchLaw(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        cls.terms = terms_for(DEVICE)

    def law(self, uses, names):
        """The terms found among some, and the criterion."""
        self.evaluator = evaluator = self.bench.evaluator(uses)
        nominal = fit_nominal(evaluator)
        criterion = make_criterion(evaluator, nominal, ())
        terms = [self.terms[name] for name in names]
        return search_law(evaluator, criterion, nominal, terms), criterion

    def test_a_soft_cable_is_a_one_sided_spring(self):
        truth = np.array([STIFFNESS, ONSET, SMOOTH])
        names = [
            f"term_ring_y_{form}"
            for form in ("spring", "cube", "above", "below", "damper", "memory")
        ]
        fit, criterion = self.law([(CABLE, truth)], names)
        ((card, values),) = fit.uses
        self.assertEqual(card.name, "term_ring_y_below")
        told = describe_term(card, values, np.zeros(4))["parameters"]
        self.assertAlmostEqual(told[0]["value"] / STIFFNESS, 1.0, delta=0.05)
        self.assertAlmostEqual(told[1]["value"], ONSET, delta=1e-4)
        self.assertGreater(criterion.closed(fit), 0.9)
        # To repair it by its law gives its block what it closes.
        row, rest = share_repairs(self.evaluator, criterion.nominal, fit, (), 0)
        self.assertEqual((row["block"], rest["block"]), ("mechanism", NONE))
        self.assertAlmostEqual(row["share"] + rest["share"], 1.0, places=9)
        left = fit.excess / criterion.nominal.excess
        self.assertAlmostEqual(rest["share"], max(0.0, left), delta=1e-9)

    def test_a_tremor_is_found_at_its_frequency(self):
        uses = [(TREMOR, np.array([0.6]))]
        evaluator = self.bench.evaluator(uses)
        nominal = fit_nominal(evaluator)
        first, *_ = residual_peaks(evaluator, nominal).swings
        # A run of 5 s tells a frequency to a fifth of a hertz.
        self.assertAlmostEqual(first, 3.1, delta=0.2)
        names = [
            f"term_torso_y_{form}" for form in ("drag", "drift", "oscillation")
        ]
        fit, _ = self.law(uses, names)
        ((card, values),) = fit.uses
        self.assertEqual(card.name, "term_torso_y_oscillation")
        self.assertAlmostEqual(values[1], 3.1, delta=0.02)
        self.assertAlmostEqual(abs(values[0]), 0.6, delta=0.06)

    def test_of_laws_of_all_blocks_that_of_the_right_one_wins(self):
        truths = (
            (CABLE, np.array([STIFFNESS, ONSET, SMOOTH])),
            (TREMOR, np.array([0.6])),
            (COGGING, np.array([0.1, 7e-4])),
        )
        for truth in truths:
            with self.subTest(truth[0].name):
                fit, _ = self.law([truth], self.terms)
                self.assertTrue(fit.effects)
                blocks = {e.block for e in fit.effects}
                self.assertEqual(blocks, {truth[0].block})

    def test_a_ripple_of_the_legs_is_found_at_its_pitch(self):
        pitch = 7e-4
        evaluator = self.bench.evaluator([(COGGING, np.array([0.1, pitch]))])
        nominal = fit_nominal(evaluator)
        found = np.array(residual_peaks(evaluator, nominal).of_legs)
        # Nearer than one wave more or less over the travel of some 8 mm.
        self.assertLess(np.abs(1.0 / found - 1.0 / pitch).min(), 1.0 / 8e-3)

    def test_noise_gets_no_law(self):
        names = [n for n in self.terms if n.startswith("term_ring_y")]
        # The search is made to try all the same.
        with mock.patch.object(Criterion, "is_beyond_level", lambda *_: True):
            fit, _ = self.law([], names)
        self.assertFalse(fit.uses)


class TestWords(unittest.TestCase):
    def row(self):
        card = terms_for(DEVICE)["term_ring_y_below"]
        values = np.array([2.0, -0.4, 0.0, float(card.parameters[-1].upper)])
        law = SimpleNamespace(
            fit=SimpleNamespace(
                uses=((card, values),),
                effects=[card],
                subject=np.zeros(1),
                num_runs=3,
            ),
            estimates=SimpleNamespace(
                num_subject=1,
                parameters=[
                    ParameterEstimate("p", "1", 0.0, e, 0.0, 0.0, False)
                    for e in (9.0, 0.1, 0.02)
                ],
            ),
            shrinkage={"closed": 0.987, "closed_interval": (0.97, 0.99)},
        )
        return law_row(law)

    def test_a_law_is_told_with_units_errors_and_what_it_closes(self):
        row = self.row()
        (term,) = row["terms"]
        errors = [p["standard_error"] for p in term["parameters"]]
        # 0.1 N at 5 mm; 0.02 times 5 mm.
        np.testing.assert_allclose(errors, [20.0, 1e-4])
        sentence = law_sentence(row)
        self.assertIn("400 N/m, where y is below -2 mm", sentence)
        self.assertIn("closes 98.7 %", sentence)
        self.assertEqual(law_sentence(law_row(None)), "")

    def test_the_page_shows_it(self):
        diagnosis = make_partly()
        diagnosis["verdict"]["unexplained"]["law"] = self.row()
        page = render_page(diagnosis, [])
        self.assertIn("c max(0, a - q)", page)
        self.assertIn("400 ± 39 N/m", page)


if __name__ == "__main__":
    unittest.main()

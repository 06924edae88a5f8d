"""Baselines find what is in residuals that are made up of known columns."""

import unittest
from types import SimpleNamespace
from unittest import mock

import numpy as np

from brace_drake.effects.registry import find_effect
from tools.baselines import least_squares, sparse
from tools.baselines.case import Case
from tools.baselines.linear import Linear
from tools.baselines.residual_model import Process
from tools.baselines.signatures import Signature

ROWS, SUBJECT = 4000, 3
EFFECTS = ("coulomb_friction", "force_lag", "hardening", "posture_drift")


def case_of(strengths, seed=0, noise=1.0):
    """A case whose residual is minus strengths times columns of EFFECTS, and
    noise; the columns are partly what a subject could change.
    """
    rng = np.random.default_rng(seed)
    S = rng.standard_normal((ROWS, SUBJECT))
    X = rng.standard_normal((ROWS, len(EFFECTS)))
    X += S @ rng.standard_normal((SUBJECT, len(EFFECTS)))
    r = -X @ np.array(strengths) + noise * rng.standard_normal(ROWS)
    whole = np.column_stack([S, X, r])
    signatures = []
    for place, name in enumerate(EFFECTS):
        card = find_effect(name)
        start = tuple(map(float, card.starts()[0]))
        signatures.append(Signature(card, (start,), place, 1))
    basis = np.linalg.qr(S)[0]
    left = r - basis @ (basis.T @ r)
    return Case(
        SimpleNamespace(),
        np.ones(SUBJECT),
        np.ones(SUBJECT),
        left,
        ROWS,
        whole.T @ whole,
        signatures,
        0.0,
    )


class TestLinearMethods(unittest.TestCase):
    METHODS = (least_squares.answer, sparse.answer)

    def setUp(self):
        # What it closes needs a twin, which a made-up case has not.
        closed = mock.patch("tools.baselines.repair.Repair")
        closed.start().return_value.closed_by.return_value = None
        self.addCleanup(closed.stop)

    def test_a_large_single_effect_is_named_with_its_block(self):
        for place, name in enumerate(EFFECTS):
            strengths = np.zeros(len(EFFECTS))
            strengths[place] = 3.0
            case = case_of(strengths)
            for method in self.METHODS:
                with self.subTest(effect=name, method=method.__module__):
                    told = method(case)
                    self.assertEqual(told["effects"], [name])
                    block = find_effect(name).block
                    self.assertEqual(told["blocks"], [block])
                    self.assertFalse(told["outside"])

    def test_noise_alone_is_no_gap(self):
        for method in self.METHODS:
            told = method(case_of([0.0] * 4))
            self.assertEqual((told["effects"], told["outside"]), ([], False))

    def test_two_effects_are_both_named(self):
        for method in self.METHODS:
            told = method(case_of([2.0, 0.0, 3.0, 0.0]))
            self.assertEqual(
                sorted(told["effects"]), ["coulomb_friction", "hardening"]
            )

    def test_what_no_signature_explains_is_outside(self):
        for method in self.METHODS:
            told = method(case_of([0.0] * 4, noise=3.0))
            self.assertEqual((told["effects"], told["outside"]), ([], True))

    def test_strengths_are_those_put_in_beside_a_subject(self):
        case = case_of([0.0, 2.0, 0.0, 0.0], noise=1e-3)
        fit = Linear(case).fit([case.signatures[1]])
        self.assertAlmostEqual(fit.strengths[0][0], 2.0, places=3)
        card, values = case.signatures[1].use(fit.strengths[0])
        self.assertAlmostEqual(values[0], 2.0 * card.starts()[0][0], places=4)
        # Of the noise's square nothing but 1e-6 is there.
        self.assertAlmostEqual(fit.misfit, -1.0, places=5)

    def test_what_cannot_be_negative_takes_nothing_where_it_would_be(self):
        case = case_of([-3.0, 0.0, 0.0, -3.0])
        linear = Linear(case)
        self.assertIsNone(linear.fit([case.signatures[0]]))
        self.assertIsNotNone(linear.fit([case.signatures[3]]))


class TestResidualModel(unittest.TestCase):
    def test_a_smooth_function_of_the_state_is_predicted(self):
        rng = np.random.default_rng(0)
        states = rng.uniform(-2.0, 2.0, (3000, 2))

        def law(x):
            return np.column_stack([np.sin(x[:, 0]), x[:, 0] * x[:, 1]])

        left = law(states) + 0.05 * rng.standard_normal((3000, 2))
        model = Process(states, left, np.repeat(np.arange(3), 1000))
        new = rng.uniform(-1.5, 1.5, (500, 2))
        error = np.sqrt(np.mean((model.mean(new) - law(new)) ** 2))
        self.assertLess(error, 0.03)


if __name__ == "__main__":
    unittest.main()

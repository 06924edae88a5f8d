"""Scaled parameters of a candidate against their plain values."""

import unittest
from dataclasses import replace
from types import SimpleNamespace
from unittest import mock

import numpy as np

from brace_drake.devices.subject import SubjectParameter
from brace_drake.effects.registry import find_effect
from brace_drake.identification.fits import search
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities


class LinearEvaluator:
    """Residuals that are known linear functions of all values."""

    def __init__(self, runs=3, rows=5):
        self.prepared = [SimpleNamespace(index=i) for i in range(runs)]
        self.ends = [rows * (i + 1) for i in range(runs)]
        self.twin = SimpleNamespace(
            has_loop=True,
            subject=(SubjectParameter("mass_kg", "kg", 40.0, 20.0, 80.0),),
        )
        self.rows, self.replays, self.tolerances = rows, 0, None

    def whitened(self, rows):
        return rows

    def coloured(self, rows):
        return rows

    def weighted_residuals(self, points, step):
        return [
            np.concatenate([self.of_run(run, *p) for run in self.prepared])
            for p in points
        ]

    def of_run(self, run, subject, uses):
        total = 0.1 * subject[0]
        for k, (effect, values) in enumerate(uses):
            own = effect.in_run(values, run.index)
            weights = np.arange(1.0, len(own) + 1) * (k + 1)
            total += weights @ own
        return total * np.arange(1.0, self.rows + 1)


class TestProblem(unittest.TestCase):
    def test_values_come_back_from_their_scaled_form(self):
        card = find_effect("hysteresis")
        values = np.array([2.0, 4e-4, 2.0, 1.0])
        problem = CandidateProblem(LinearEvaluator(), [card], [values])
        z = problem.join(np.array([44.0]), [values])
        self.assertEqual(len(z), 3)  # discrete parameters are not moved
        subject, ((_, back),) = problem.split(z)
        np.testing.assert_allclose(subject, [44.0])
        np.testing.assert_allclose(back, values)

    def test_each_run_has_run_parameters_of_its_own(self):
        card = find_effect("breathing")
        values = card.starts()[0]
        problem = CandidateProblem(LinearEvaluator(), [card], [values])
        z = problem.join(np.array([40.0]), [values])
        own = len(card.run_parameters)
        self.assertEqual(len(z), 1 + len(values) + 3 * own)
        z[problem.places_in_run(card, 1)[0]] = 0.5
        _, uses = problem.split(z)
        phases = [card.in_run(uses[0][1], r)[len(values)] for r in range(3)]
        scale = problem.scales[problem.places_in_run(card, 1)[0]]
        np.testing.assert_allclose(phases, [0.0, 0.5 * scale, 0.0])

    def test_a_prior_of_the_subject_weighs_as_bayes_rule_says(self):
        evaluator = LinearEvaluator()
        (mass,) = evaluator.twin.subject
        # Runs alone say 44 kg, what is known beforehand 40.
        told, known = 44.0, replace(mass, deviation=0.3)
        slope = 0.1 * np.tile(np.arange(1.0, 6.0), 3)
        evaluator.twin.subject = (known,)
        with mock.patch.object(
            evaluator,
            "weighted_residuals",
            lambda points, step: [(s[0] - told) * slope for s, _ in points],
        ):
            problem = CandidateProblem(evaluator, ())
            solution = search(problem, problem.join(np.array([60.0]), ()))
        weights = slope @ slope, 1.0 / known.deviation**2
        mean = (weights[0] * told + weights[1] * 40.0) / sum(weights)
        (found,), _ = problem.split(solution.z)
        self.assertAlmostEqual(found, mean, places=6)
        # The prior is a row below those of the runs.
        self.assertEqual(len(solution.residual), len(slope) + 1)
        off = (mean - 40.0) / known.deviation
        self.assertAlmostEqual(solution.residual[-1], off, places=6)

    def test_columns_of_a_linear_residual_are_exact_for_every_run(self):
        card = find_effect("breathing")
        values = card.starts()[0]
        evaluator = LinearEvaluator()
        problem = CandidateProblem(evaluator, [card], [values])
        z = problem.join(np.array([40.0]), [values])
        columns = calc_sensitivities(problem, z)
        step = 1e-3 * np.cos(np.arange(len(z)))
        before, after = problem.batch([z, z + step])
        np.testing.assert_allclose(columns @ step, after - before, atol=1e-9)

    def test_priors_add_a_row_for_each_parameter_that_has_one(self):
        card = find_effect("anchor_error")
        problem = CandidateProblem(
            LinearEvaluator(), [card], [np.zeros(len(card.parameters))]
        )
        problem.spread = 2.0
        self.assertEqual(problem.num_prior, 36)
        z = np.ones(37)
        np.testing.assert_allclose(problem.prior_rows(z), 0.5)
        rows = problem.prior_jacobian() @ z
        np.testing.assert_allclose(rows, problem.prior_rows(z))
        # Beside 8 squares that a fit leaves for each of them, the rows are
        # three times what they are beside noise alone.
        problem.weigh_alike(8.0 * 36)
        np.testing.assert_allclose(problem.prior_rows(z), 1.5)
        problem.weigh_alike()
        np.testing.assert_allclose(problem.prior_rows(z), 0.5)


if __name__ == "__main__":
    unittest.main()

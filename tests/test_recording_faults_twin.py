"""Runs of another subject, by quadratics whose answer is known."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.recording_faults.against_twin.subjects import divide


def fit_of(z, seed, rows=400):
    """A run's fit that ends at z, noise alone left."""
    noise = np.random.default_rng(seed)
    solution = SimpleNamespace(
        jacobian=30.0 * noise.standard_normal((rows, len(z))),
        residual=noise.standard_normal(rows),
    )
    evaluator = SimpleNamespace(count=rows)
    scaled = np.array(z, dtype=float)
    return SimpleNamespace(
        solution=solution, evaluator=evaluator, scaled=scaled, level=1.0
    )


class TestOtherSubjects(unittest.TestCase):
    def test_runs_of_another_subject_are_divided_from_the_rest(self):
        one, two = [1.0, 1.0, 1.0], [1.2, 0.9, 1.0]
        subjects = [one, two, one, one, two]
        fits = [fit_of(z, i) for i, z in enumerate(subjects)]
        found = divide(fits)
        self.assertEqual(found.others, (1, 4))
        self.assertGreater(found.one, 5.0)
        self.assertLess(abs(found.two), 0.2)
        np.testing.assert_allclose(found.first, one, atol=1e-9)
        np.testing.assert_allclose(found.second, two, atol=1e-9)

    def test_one_subject_gains_little_by_two(self):
        noise = np.random.default_rng(9)
        fits = [
            fit_of(1.0 + 1e-3 * noise.standard_normal(3), i) for i in range(5)
        ]
        found = divide(fits)
        self.assertLess(found.one - found.two, 0.1)

    def test_a_single_run_is_not_divided(self):
        self.assertIsNone(divide([fit_of([1.0], 0)]))


if __name__ == "__main__":
    unittest.main()

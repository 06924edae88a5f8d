"""The triangle of tall matrices."""

import unittest

import numpy as np

from brace_drake.identification.least_squares import calc_triangle


class TestTriangle(unittest.TestCase):
    def test_its_normal_equations_are_those_of_the_columns(self):
        rng = np.random.default_rng(0)
        for rows in (3, 40, 2000, 2001, 9137):
            J, r = rng.standard_normal((rows, 7)), rng.standard_normal(rows)
            R, A = calc_triangle([J, r]), np.column_stack([J, r])
            self.assertEqual(R.shape, (min(rows, 8), 8))
            np.testing.assert_allclose(R, np.triu(R))
            np.testing.assert_allclose(R.T @ R, A.T @ A, atol=1e-10 * rows)

    def test_nearly_equal_columns_keep_what_sets_them_apart(self):
        # Squared, as normal equations would, 1e-9 is below the rounding.
        rng = np.random.default_rng(1)
        a, b = rng.standard_normal((2, 10000))
        b -= a * (a @ b) / (a @ a)
        R = calc_triangle([a, a + 1e-9 * b])
        self.assertAlmostEqual(
            abs(R[1, 1]) / (1e-9 * np.linalg.norm(b)), 1.0, places=5
        )


if __name__ == "__main__":
    unittest.main()

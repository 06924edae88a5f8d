"""Tests of how far numbers known to a tolerance are stretched."""

import unittest

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.stretch import noise_along, stretch_of
from brace_drake.devices.tolerances import LinearTolerances

ROWS = 400


def known_with(changes):
    """Numbers that change a residual so per deviation (rows, n)."""
    basis, columns = np.linalg.qr(changes)
    numbers = [
        Nuisance(f"number{i}_m", "m", "mechanism", 1e-3, ())
        for i in range(changes.shape[1])
    ]
    return LinearTolerances(tuple(numbers), basis, columns)


class StretchTest(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(5)

    def test_an_error_that_alike_numbers_share_shows_as_a_whole(self):
        # Four numbers that cannot be told apart: each takes a quarter of their
        # common error, which has twice the deviation of one.
        one = self.random.normal(size=ROWS)
        others = self.random.normal(size=(ROWS, 12))
        known = known_with(np.column_stack([*[one] * 4, others]))
        residual = -12.0 * one
        whitened = known.whiten(residual)
        self.assertAlmostEqual(stretch_of(known, whitened), 6.0, delta=0.05)
        self.assertAlmostEqual(
            float(np.max(np.abs(known.estimate(known.along(whitened))))),
            3.0,
            delta=0.05,
        )

    def test_estimates_of_right_numbers_move_by_one_deviation(self):
        changes = self.random.normal(size=(ROWS, 8)) * np.geomspace(0.01, 3, 8)
        known = known_with(changes)
        free = np.sqrt(1.0 - known.errors() ** 2)
        draws = [
            known.estimate(
                known.along(
                    known.whiten(
                        self.random.normal(size=ROWS)
                        - changes @ self.random.normal(size=8)
                    )
                )
            )
            / free
            for _ in range(2000)
        ]
        np.testing.assert_allclose(np.std(draws, axis=0), 1.0, atol=0.06)

    def test_noise_along_numbers_is_found_beside_one_that_is_far_off(self):
        changes = 0.3 * self.random.normal(size=(ROWS, 60))
        known = known_with(changes)
        found = []
        for _ in range(40):
            right = self.random.normal(size=60)
            right[7] = 30.0
            residual = 5.0 * self.random.normal(size=ROWS) + changes @ right
            found.append(
                noise_along(known, known.along(known.whiten(residual)))
            )
        self.assertAlmostEqual(float(np.mean(found)), 25.0, delta=4.0)

    def test_noise_along_numbers_is_never_less_than_that_of_the_readings(self):
        known = known_with(self.random.normal(size=(ROWS, 20)))
        self.assertEqual(noise_along(known, known.along(np.zeros(ROWS))), 1.0)


if __name__ == "__main__":
    unittest.main()

"""Tests of how far numbers known to a tolerance are stretched."""

import math
import unittest

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.stretch import as_of_one, noise_along, stretch_of
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
        # Three times two; of thirteen directions one is so far off.
        expected = as_of_one(6.0, 13.0)
        found = stretch_of(known, whitened)
        self.assertAlmostEqual(found, expected, delta=0.05)
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

    def test_of_one_number_it_is_that_numbers_own(self):
        for off in (0.3, 2.0, 6.0, 20.0, 60.0):
            self.assertAlmostEqual(as_of_one(off, 1.0), off, places=6)

    def test_the_farthest_of_many_is_told_by_its_chance(self):
        for off, number in ((2.5, 20.0), (3.0, 43.0), (4.0, 7.0)):
            each = math.erfc(off / math.sqrt(2.0))
            chance = 1.0 - (1.0 - each) ** number
            found = as_of_one(off, number)
            self.assertAlmostEqual(
                math.erfc(found / math.sqrt(2.0)), chance, places=9
            )
        self.assertLess(as_of_one(40.0, 43.0), 40.0)
        self.assertGreater(as_of_one(40.0, 43.0), 39.8)

    def test_right_numbers_are_beyond_two_deviations_as_often_as_one(self):
        changes = self.random.normal(size=(ROWS, 40))
        known = known_with(changes)
        draws = []
        for _ in range(1500):
            right = self.random.normal(size=40)
            residual = self.random.normal(size=ROWS) + changes @ right
            draws.append(stretch_of(known, known.whiten(residual)))
        # 4.6 % of 1500, with a standard error of 0.5 %.
        beyond = np.mean(np.array(draws) > 2.0)
        self.assertAlmostEqual(beyond, 0.0455, delta=0.015)

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

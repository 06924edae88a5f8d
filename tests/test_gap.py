"""Intervals of errors on validation runs."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.identification.gap import interval_of_rms

RATE, BLOCKS = 100.0, 400


def run_of(squares):
    """A comparison of a run of so many samples."""
    run = SimpleNamespace(time_s=np.arange(len(squares)) / RATE)
    return SimpleNamespace(prepared=SimpleNamespace(run=run))


class TestRmsInterval(unittest.TestCase):
    def setUp(self):
        self.generator = np.random.default_rng(2)

    def width(self, squares):
        low, high = interval_of_rms([run_of(squares)], [[squares]], 0)
        rms = np.sqrt(np.mean(squares))
        self.assertTrue(low < rms < high)
        return high - low

    def test_of_white_noise_it_is_that_of_its_chi_square(self):
        squares = self.generator.standard_normal(round(BLOCKS * RATE)) ** 2
        # The mean of n squares strays by sqrt(2 / n), its root by half of it.
        expected = 2.0 * 1.96 * 0.5 * np.sqrt(2.0 / len(squares))
        self.assertAlmostEqual(self.width(squares) / expected, 1.0, delta=0.15)

    def test_errors_that_last_count_once_a_block(self):
        errors = self.generator.standard_normal(BLOCKS)
        squares = np.repeat(errors, round(RATE)) ** 2
        expected = 2.0 * 1.96 * 0.5 * np.sqrt(2.0 / BLOCKS)
        self.assertAlmostEqual(self.width(squares) / expected, 1.0, delta=0.2)

    def test_a_value_counts_as_much_in_a_short_block_or_beside_others(self):
        # One large value at the end, in a block of its own, and a run of more
        # channels: a draw with k times that value, m blocks of one channel and
        # the others of three has the mean (100 k + 100 m + 300 n) / all.
        last = np.append(np.ones(800), 100.0)[:, None]
        wide = np.ones((800, 3))
        low, high = interval_of_rms(
            [run_of(last), run_of(wide)], [[last, wide]], 0
        )
        self.assertGreater(high, 1.0)
        # With five of them, and 12 blocks of 1: 1.3.
        self.assertLess(high, np.sqrt((500.0 + 1200.0) / (5.0 + 1200.0)))
        self.assertEqual(low, 1.0)

    def test_the_same_seed_draws_the_same(self):
        squares = self.generator.standard_normal(5000) ** 2
        first, again = (
            interval_of_rms([run_of(squares)], [[squares]], 7) for _ in range(2)
        )
        self.assertEqual(first, again)


if __name__ == "__main__":
    unittest.main()

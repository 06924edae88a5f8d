"""Calibration of stated probabilities on answers of known chances."""

import unittest

import numpy as np

from tools.calibrate_probability import fit_calibration, log_odds


def answers(offset, slope, count, seed=0):
    """Statements, and answers right by offset + slope * their log-odds."""
    generator = np.random.default_rng(seed)
    stated = generator.uniform(0.3, 0.98, count)
    p = 1.0 / (1.0 + np.exp(-(offset + slope * log_odds(stated))))
    return stated, generator.random(count) < p


class TestCalibration(unittest.TestCase):
    def test_what_the_answers_were_drawn_with_is_found(self):
        found = fit_calibration(*answers(-0.7, 0.6, 20_000))
        errors = np.sqrt(np.diag(found.covariance))
        self.assertLess(abs(found.offset + 0.7), 3.0 * errors[0])
        self.assertLess(abs(found.slope - 0.6), 3.0 * errors[1])
        self.assertLess(errors.max(), 0.05)

    def test_without_answers_a_statement_stays_as_it_is(self):
        found = fit_calibration(np.zeros(0), np.zeros(0, dtype=bool))
        stated = np.array([0.1, 0.5, 0.93])
        np.testing.assert_allclose(found.apply(stated), stated, atol=1e-6)

    def test_errors_cover_the_truth_as_often_as_they_say(self):
        # Two standard errors hold 95 %; the prior pulls both a bit inwards.
        inside = 0
        for seed in range(200):
            found = fit_calibration(*answers(0.0, 1.0, 100, seed))
            error = np.sqrt(found.covariance[1, 1])
            inside += abs(found.slope - 1.0) < 2.0 * error
        self.assertGreater(inside, 180)

    def test_mean_statement_becomes_the_share_that_was_right(self):
        stated, right = answers(-1.5, 1.0, 2_000)
        found = fit_calibration(stated, right)
        self.assertGreater(stated.mean(), right.mean() + 0.15)
        self.assertAlmostEqual(
            found.apply(stated).mean(), right.mean(), delta=0.01
        )


if __name__ == "__main__":
    unittest.main()

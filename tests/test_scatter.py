"""A common spread: a draw from it looks like one, an imitation does not."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import LeastSquaresSolution
from brace_drake.identification.prior_check import (
    looks_scattered,
    refit_spread,
    whiten,
)

SUBJECT, ALIKE, ROWS, SPREAD = 3, 36, 400, 0.7


def effect(spread):
    return SimpleNamespace(
        name="many",
        key="many",
        cause="many",
        parameters=(),
        is_flexible=True,
        spread=spread,
        run_parameters=(),
        is_continuous=np.ones(ALIKE, bool),
    )


def fit_of(truth, rng, spread=("anchor_m", "m")):
    """Posterior of a linear model with noise of unit variance."""
    columns = rng.standard_normal((ROWS, SUBJECT + ALIKE))
    columns *= np.geomspace(30.0, 1e-3, SUBJECT + ALIKE)
    data = columns @ np.concatenate([np.ones(SUBJECT), truth])
    data = data + rng.standard_normal(ROWS)
    prior = np.zeros((ALIKE, SUBJECT + ALIKE))
    prior[:, SUBJECT:] = np.eye(ALIKE) / SPREAD
    jacobian = np.vstack([columns, prior])
    target = np.concatenate([data, np.zeros(ALIKE)])
    z = np.linalg.lstsq(jacobian, target, rcond=None)[0]
    solution = LeastSquaresSolution(z, jacobian @ z - target, jacobian, 1, True)
    scales = np.ones(SUBJECT + ALIKE)
    return CandidateFit(
        (effect(spread),), np.ones(SUBJECT), (z[SUBJECT:],), solution, scales,
        0.0, SPREAD, 1, ALIKE,
    )  # fmt: skip


def draw(rng):
    return SPREAD * rng.standard_normal(ALIKE)


def posterior_of(fit):
    """Mean and covariance of the alike parameters."""
    jacobian = fit.solution.jacobian
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    return fit.solution.z[SUBJECT:], covariance[SUBJECT:, SUBJECT:]


class TestScatter(unittest.TestCase):
    def test_a_whitened_draw_has_unit_variance(self):
        rng = np.random.default_rng(5)
        draws = [
            whiten(*posterior_of(fit_of(draw(rng), rng)), SPREAD)
            for _ in range(60)
        ]
        sample = np.concatenate(draws)
        self.assertGreater(len(sample), 600)
        error = 4.0 * np.sqrt(2.0 / len(sample))
        self.assertAlmostEqual(np.mean(sample**2), 1.0, delta=error)

    def test_the_spread_is_a_fixed_point_at_that_of_the_draw(self):
        rng = np.random.default_rng(9)
        found = [
            refit_spread(*posterior_of(fit_of(draw(rng), rng)), SPREAD)
            for _ in range(60)
        ]
        self.assertAlmostEqual(np.median(found) / SPREAD, 1.0, delta=0.1)

    def test_strays_do_not_draw_the_spread_after_them(self):
        rng = np.random.default_rng(10)
        mean, covariance = posterior_of(fit_of(draw(rng), rng))
        plain = refit_spread(mean, covariance, SPREAD)
        weak = np.linalg.eigh(covariance / SPREAD**2)
        place = np.flatnonzero(weak[0] < 0.5)[-1]
        strayed = mean + 50.0 * SPREAD * weak[1][:, place]
        found = refit_spread(strayed, covariance, SPREAD)
        self.assertAlmostEqual(found / plain, 1.0, delta=0.15)

    def test_draws_are_hardly_ever_refused(self):
        rng = np.random.default_rng(6)
        fits = [fit_of(draw(rng), rng) for _ in range(100)]
        self.assertGreaterEqual(sum(map(looks_scattered, fits)), 98)

    def test_a_few_directions_that_carry_all_are_no_draw(self):
        rng = np.random.default_rng(7)
        truth = np.zeros(ALIKE)
        truth[[2, 5]] = SPREAD * np.sqrt(ALIKE / 2.0)
        self.assertFalse(looks_scattered(fit_of(truth, rng)))

    def test_strays_are_no_draw(self):
        rng = np.random.default_rng(11)
        truth = draw(rng)
        truth[[1, 4, 9]] = 10.0 * SPREAD
        self.assertFalse(looks_scattered(fit_of(truth, rng)))

    def test_effects_without_a_common_spread_are_not_asked(self):
        rng = np.random.default_rng(8)
        self.assertTrue(looks_scattered(fit_of(np.zeros(ALIKE), rng, None)))


if __name__ == "__main__":
    unittest.main()

"""The bounded Gauss-Newton search on problems with known answers."""

import unittest

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import ortho_group

from brace_drake.identification.least_squares import solve_gauss_newton

T = np.linspace(0.0, 3.0, 60)


def batch_of(data):
    def batch(points, coarse=False):
        return [data - z[0] * np.exp(-z[1] * T) for z in points]

    return batch


def solve(batch, start, lower, upper, **options):
    n = len(start)
    return solve_gauss_newton(
        batch,
        np.array(start),
        np.array(lower),
        np.array(upper),
        np.full(n, 1e-6),
        np.full(n, 1.0),
        tolerance=1e-12,
        max_iterations=40,
        **options,
    )


class TestGaussNewton(unittest.TestCase):
    def test_the_parameters_of_an_exponential_are_recovered(self):
        data = 2.0 * np.exp(-0.7 * T)
        found = solve(batch_of(data), [1.0, 1.5], [0, 0], [9, 9])
        np.testing.assert_allclose(found.z, [2.0, 0.7], atol=1e-6)

    def test_a_limit_is_kept_and_the_rest_is_optimal_given_it(self):
        data = 2.0 * np.exp(-0.7 * T)
        found = solve(batch_of(data), [1.0, 0.3], [0, 0], [9, 0.5])
        basis = np.exp(-0.5 * T)
        self.assertAlmostEqual(found.z[1], 0.5)
        self.assertAlmostEqual(
            found.z[0], basis @ data / (basis @ basis), places=5
        )

    def test_a_jacobian_from_the_start_leads_to_the_same_answer(self):
        data = 2.0 * np.exp(-0.7 * T)
        batch, start = batch_of(data), np.array([1.8, 0.8])
        full = solve(batch, start, [0, 0], [9, 9])
        (residual,) = batch([start])
        decay = np.exp(-0.8 * T)
        jacobian = np.column_stack([-decay, 1.8 * T * decay])
        known = residual, jacobian
        kept = solve(batch, start, [0, 0], [9, 9], known=known)
        np.testing.assert_allclose(kept.z, full.z, atol=1e-5)

    def test_a_curved_valley_of_many_parameters_is_followed_down(self):
        # Along the last of these coordinates the residual says little, and
        # the others bend with it: a full step lands far up the wall.
        turn = ortho_group.rvs(14, random_state=0)

        def residual(z):
            *others, along = turn @ z
            wall = np.array(others) - 0.1 * along**2 - 0.1 * np.arange(13)
            floor = [0.01 * (along - 100), 0.01 * along**2]
            return np.append(30.0 * wall, floor)

        best = least_squares(residual, np.zeros(14), method="lm")
        found = solve_gauss_newton(
            lambda points, coarse=False: [residual(z) for z in points],
            np.zeros(14),
            np.full(14, -1e3),
            np.full(14, 1e3),
            np.full(14, 1e-4),
            np.full(14, 1e3),
            max_iterations=60,
        )
        self.assertLess(found.cost, 1.05 * 2.0 * best.cost)

    def test_noise_in_a_jacobian_hardly_slows_the_search(self):
        # Its second row is noise: each step is a fifth of what it should be.
        found = solve(
            lambda points, coarse=False: [
                np.array([z[0] - 5.0, 0.0]) for z in points
            ],
            [0.0],
            [-9],
            [9],
            differentiate=lambda z, residual: np.array([[1.0], [2.0]]),
        )
        self.assertLess(found.iterations, 20)
        self.assertAlmostEqual(found.z[0], 5.0, places=5)

    def test_a_point_that_fails_is_stepped_back_from(self):
        data = 2.0 * np.exp(-0.7 * T)
        plain = batch_of(data)

        def fragile(points, coarse=False):
            found = plain(points)
            return [
                None if z[1] < 0.6 else r
                for z, r in zip(points, found, strict=True)
            ]

        found = solve(fragile, [1.0, 2.5], [0, 0], [9, 9])
        np.testing.assert_allclose(found.z, [2.0, 0.7], atol=1e-5)

    def test_a_start_that_fails_is_an_error(self):
        with self.assertRaises(ValueError):
            solve(lambda p, coarse=False: [None] * len(p), [1.0], [0], [9])

    def test_sensitivities_of_elsewhere_do_not_hide_a_limit(self):
        # Of a drive's limit L = 6.6; that of the first parameter, which is
        # right already, is from elsewhere and takes what the limit leaves.
        t = np.linspace(0.0, 12.0, 600)
        x = 7.3 * np.sin(t)

        def model(z):
            return np.clip(x, -z[1], z[1]) + 0.5 * (z[0] - 1.0) * np.cos(3 * t)

        def differentiate(z, residual):
            wrong = np.clip(x, -8.0, 8.0) - np.clip(x, -5.0, 5.0)
            own = model(z + np.array([0.0, 1e-4])) - model(z)
            return np.column_stack([wrong, own / 1e-4])

        data, left = model(np.array([1.0, 6.6])), []
        for first in (0, 1):
            found = solve_gauss_newton(
                lambda points, coarse=False: [model(z) - data for z in points],
                np.array([1.0, 5.0]),
                np.array([0.1, 0.1]),
                np.array([10.0, 20.0]),
                np.full(2, 1e-3),
                np.array([0.3, 5.0]),
                differentiate=differentiate,
                max_iterations=5,
                first=first,
            )
            left.append(found.residual @ found.residual)
        self.assertAlmostEqual(found.z[0], 1.0)
        self.assertAlmostEqual(found.z[1], 6.6, delta=0.2)
        self.assertLess(left[1], 0.1 * left[0])


if __name__ == "__main__":
    unittest.main()

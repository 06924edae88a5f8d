"""Noise floor and weights against noise of known spectrum."""

import unittest

import numpy as np

from brace_drake.core.cosine_transform import to_frequency
from brace_drake.identification.noise_floor import (
    estimate_floor,
    repeat_ratio,
    written_quantum,
)


def coloured(generator, count, samples=2000):
    """White noise of 0.5 and a slow random walk with known variance."""
    white = 0.5 * generator.standard_normal((count, samples, 1))
    slow = generator.standard_normal((count, samples, 1))
    for i in range(1, samples):
        slow[:, i] = 0.95 * slow[:, i - 1] + np.sqrt(1 - 0.95**2) * slow[:, i]
    return np.concatenate([white, slow], axis=2)


class TestFloor(unittest.TestCase):
    def setUp(self):
        self.generator = np.random.default_rng(4)
        noise = coloured(self.generator, 40)
        self.floor = estimate_floor(noise, 200.0)

    def test_weighted_noise_has_unit_variance_in_every_channel(self):
        weights = self.floor.weights(2000, 200.0)
        fresh = coloured(self.generator, 20)
        transform = to_frequency(fresh, axis=1) * weights
        energy = (transform**2).mean(axis=(0, 1))
        np.testing.assert_allclose(energy, 1.0, atol=0.03)

    def test_noise_that_is_integrated_has_unit_variance_in_every_series(self):
        # Its mean square scatters as that of so many independent values.
        walks = np.cumsum(self.generator.standard_normal((80, 2000, 1)), axis=1)
        floor = estimate_floor(walks[:40], 200.0)
        weighted = to_frequency(walks[40:], axis=1)
        weighted = weighted * floor.weights(2000, 200.0)
        squares = (weighted**2).mean(axis=1)
        self.assertLess(np.std(squares), 1.5 * np.sqrt(2.0 / 2000))
        ratios = [
            repeat_ratio(a - b, floor, 200.0)
            for a, b in zip(walks[::2], walks[1::2], strict=True)
        ]
        np.testing.assert_allclose(ratios, 1.0, atol=0.3)

    def test_the_root_mean_square_is_that_of_the_noise(self):
        np.testing.assert_allclose(self.floor.rms, [0.5, 1.0], rtol=0.05)

    def test_a_repeat_of_doubled_noise_shows_four_times_the_variance(self):
        first, second = 2.0 * coloured(self.generator, 2)
        ratio = repeat_ratio(first - second, self.floor, 200.0)
        np.testing.assert_allclose(ratio, 4.0, rtol=0.25)

    def test_a_slow_motion_that_did_not_repeat_leaves_the_ratio_alone(self):
        first, second = coloured(self.generator, 2)
        t = np.arange(2000)[:, None] / 200.0
        drift = 50.0 * np.sin(2 * np.pi * 0.3 * t)
        ratio = repeat_ratio(first - second + drift, self.floor, 200.0)
        np.testing.assert_allclose(ratio, 1.0, atol=0.3)

    def test_the_step_of_written_decimals_is_found(self):
        values = self.generator.standard_normal((500, 2))
        written = np.column_stack([values[:, 0].round(3), values[:, 1]])
        quantum = written_quantum(written, np.zeros(2))
        self.assertAlmostEqual(quantum[0], 1e-3, delta=1e-9)
        self.assertLess(quantum[1], 1e-9)

    def test_coarse_readings_have_the_noise_of_their_steps(self):
        # Ramps and rests, less noise than a step: rounding is nowhere white.
        t = np.arange(2000) / 200.0
        ways = np.interp(t, [0, 2, 5, 7, 10], [0, 1, 1, 3, 3])
        shifts = self.generator.random((60, 1)) * 0.2
        exact = (ways + shifts)[:, :, None]
        noise = 0.01 * self.generator.standard_normal(exact.shape)
        rounding = 0.2 * np.round((exact + noise) / 0.2) - exact - noise
        half = noise[:30], rounding[:30]
        floor = estimate_floor(half[0], 200.0, half[1])
        rest = to_frequency(noise[30:] + rounding[30:], axis=1)
        squares = np.mean((rest * floor.weights(2000, 200.0)) ** 2)
        self.assertAlmostEqual(squares, 1.0, delta=0.15)
        # Repeats that round alike take nothing from it.
        alike = floor.scaled(np.array([0.01]))
        most = (rest * alike.weights(2000, 200.0))[:, 1:] ** 2
        self.assertLess(np.mean(most), 1.5)

    def test_rounding_that_is_noise_of_the_instrument_counts_once(
        self,
    ):
        values = self.generator.standard_normal((500, 1)).round(3)
        self.assertEqual(written_quantum(values, np.array([1e-3]))[0], 0.0)


if __name__ == "__main__":
    unittest.main()

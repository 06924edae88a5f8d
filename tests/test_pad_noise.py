"""Noise and path of a pad from its recordings."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.laws.alone.pad_path import (
    filter_cosines,
    noise_gain,
    path_slopes,
)
from brace_drake.scenario.pad_noise import (
    estimate_displacement_noise,
    estimate_force_noise,
    white_noise,
)
from tests.pad_recordings import (
    STAIRS,
    exact_run,
    linear,
    make_campaign,
    relaxing,
)


class TestNoise(unittest.TestCase):
    def test_white_noise_is_told_from_the_motion(self):
        runs = make_campaign(relaxing).split("fit")[:3]
        found = estimate_force_noise(runs, 100.0)
        # An upper end: at most two standard errors, 3.5 % each, too large.
        np.testing.assert_allclose(found, 0.021, rtol=0.06)
        displacement = estimate_displacement_noise(runs)
        self.assertAlmostEqual(displacement / 2e-6, 1.05, delta=0.06)

    def test_a_clean_path_of_straight_pieces_has_none(self):
        run = exact_run(STAIRS, linear, rate=100.0)
        noise = white_noise(run.channels["displacement_m"])
        self.assertLess(noise, 1e-12)

    def test_rounding_is_noise(self):
        time = np.arange(5000) / 100.0
        reading = np.round(5.0 * np.sin(time), 1)
        noise = white_noise(reading)
        self.assertAlmostEqual(noise / (0.1 / np.sqrt(12.0)), 1.0, delta=0.3)

    def test_what_does_not_repeat_counts_where_it_is(self):
        campaign = make_campaign(linear)
        runs = list(campaign.split("fit"))
        time = runs[3].time_s
        slow = 0.5 * np.sin(2.0 * np.pi * 0.5 * time)
        channels = runs[3].channels
        channels = channels | {"force_N": channels["force_N"] + slow}
        runs[3] = replace(runs[3], channels=channels)
        found = estimate_force_noise(runs, 100.0)
        self.assertGreater(found[2], 5.0 * found[-1])
        self.assertAlmostEqual(found[-1] / 0.021, 1.0, delta=0.1)


class TestPath(unittest.TestCase):
    def slopes(self, corner, sigma=0.0):
        """Of a ramp of 1 m/s that stops at `corner` samples."""
        time = np.arange(20.0)
        return path_slopes(time, np.minimum(time, corner), sigma)

    def test_a_corner_between_samples_is_where_it_is(self):
        rate, jumps = self.slopes(9.5)
        np.testing.assert_allclose(rate, [1.0] * 10 + [0.0] * 10, atol=1e-4)
        self.assertEqual(np.abs(jumps).max(), 0.0)

    def test_at_a_corner_on_a_sample_the_rate_is_in_doubt(self):
        rate, jumps = self.slopes(9.0)
        expected = [1.0] * 9 + [0.5] + [0.0] * 10
        np.testing.assert_allclose(rate, expected, atol=1e-4)
        np.testing.assert_array_equal(np.flatnonzero(jumps), [9])
        self.assertAlmostEqual(jumps[9], -1.0, delta=1e-9)

    def test_noise_is_no_corner(self):
        noise = 1e-3 * np.random.default_rng(0).standard_normal(500)
        _, jumps = path_slopes(np.arange(500.0), noise, 1e-3)
        self.assertEqual(np.abs(jumps).max(), 0.0)

    def test_a_smooth_motion_has_its_rate(self):
        time = np.arange(400) / 100.0
        rate, _ = path_slopes(time, np.sin(3.0 * time), 0.0)
        # Akima's slopes are of second order: (w h)^2 / 2 at the most.
        np.testing.assert_allclose(
            rate[2:-2], 3.0 * np.cos(3.0 * time)[2:-2], atol=3.0 * 4.5e-4
        )

    def test_smoothing_takes_the_noise_and_leaves_the_motion(self):
        time = np.arange(5000) / 1000.0
        clean = 0.005 * (1.0 - np.cos(2.0 * np.pi * time))
        np.testing.assert_array_equal(
            filter_cosines(clean, noise_gain(clean, 0.0)), clean
        )
        noise = 1e-5 * np.random.default_rng(0).standard_normal(len(time))
        gain = noise_gain(clean + noise, 1e-5)
        rest = filter_cosines(clean + noise, gain) - clean
        self.assertLess(np.std(rest), 0.2e-5)

    def test_a_record_that_ends_while_it_moves_has_no_corner_there(self):
        time = np.arange(1200) / 100.0
        w, sigma = 2.0 * np.pi * 0.37, 1e-5
        clean = 0.1 * np.sin(w * time + 0.4)
        noise = sigma * np.random.default_rng(1).standard_normal(len(time))
        gain = noise_gain(clean + noise, sigma)
        # Half waves below 5 Hz; a corner would stand out at all frequencies.
        self.assertLess(np.count_nonzero(gain > 0.5), 12 * 10)
        smooth = filter_cosines(clean + noise, gain)
        rate, _ = path_slopes(time, smooth, sigma)
        error = rate - 0.1 * w * np.cos(w * time + 0.4)
        self.assertLess(np.abs(error).max(), 0.01 * 0.1 * w)

    def test_what_smoothing_leaves_unknown_has_the_power_that_is_told(self):
        # Of an acceleration that leaps: the power of the motion falls with the
        # sixth power of the frequency.
        time, sigma = np.arange(6000) / 500.0, 1e-4
        push = np.where(np.mod(time, 3.0) < 1.5, 2.0, -2.0)
        speed = np.cumsum(push) / 500.0
        clean = np.cumsum(speed - speed.mean()) / 500.0
        ratios = []
        for seed in range(20):
            noise = np.random.default_rng(seed).standard_normal(len(time))
            gain = noise_gain(clean + sigma * noise, sigma)
            rest = filter_cosines(clean + sigma * noise, gain) - clean
            told = sigma * np.sqrt(np.mean(gain))
            ratios.append(np.sqrt(np.mean(rest[200:-200] ** 2)) / told)
        self.assertGreater(np.mean(ratios), 0.7)
        self.assertLess(np.mean(ratios), 1.4)

    def test_rounding_of_a_periodic_motion_is_no_motion(self):
        # 500 samples a second are a whole number in a period of 2.5 s: what
        # an encoder's steps add is lines at all harmonics.
        time, step = np.arange(6000) / 500.0, 2.0 * np.pi / 16384.0
        w = 2.0 * np.pi * 0.4
        clean = 0.9 * (1.0 - np.cos(w * time))
        read = step * np.round(clean / step)
        gain = noise_gain(read, step / np.sqrt(12.0))
        # Half waves below 10 Hz.
        self.assertLess(np.count_nonzero(gain > 0.5), 2 * 12 * 10)
        smooth = filter_cosines(read, gain)
        rate, _ = path_slopes(time, smooth, step / np.sqrt(12.0))
        bend = np.gradient(rate, time)[100:-100]
        wanted = 0.9 * w**2 * np.cos(w * time)[100:-100]
        error = np.sqrt(np.mean((bend - wanted) ** 2))
        self.assertLess(error, 0.02 * 0.9 * w**2)


if __name__ == "__main__":
    unittest.main()

"""How far the motion of an axis is known, and times that are rounded."""

import unittest

import numpy as np

from brace_drake.devices.axis.motion import AxisMotion
from brace_drake.devices.pad_bench.motion import MakePadMotion
from brace_drake.recording.samples import without_rounding

RATE = 100.0
TIME = np.arange(1200) / RATE


def motion_of(way, sigma=5e-6):
    noise = sigma * np.random.default_rng(3).standard_normal(len(way))
    return AxisMotion(
        MakePadMotion(TIME, way + noise, sigma), np.zeros((len(way), 0))
    )


class TestTrust(unittest.TestCase):
    def test_a_smooth_motion_is_known_but_at_its_ends(self):
        motion = motion_of(0.1 * np.sin(2.0 * np.pi * 0.4 * TIME))
        trust = motion.trust(5.0, 0.15)
        self.assertEqual((trust[0], trust[-1]), (0.0, 0.0))
        self.assertGreater(trust[60:-60].min(), 0.9)

    def test_at_a_corner_no_force_is_known(self):
        # Triangles of 2.5 s, turned round by a soft machine in 20 ms.
        way = 0.1 * np.abs((TIME / 2.5) % 1.0 - 0.5)
        way = np.convolve(way, np.full(3, 1.0 / 3.0), mode="same")
        trust = motion_of(way).trust(5.0, 0.15)
        turns = np.arange(125, 1150, 125)
        self.assertLess(trust[turns].max(), 0.01)
        between = np.abs(np.arange(1200)[:, None] - turns).min(axis=1) > 20
        between[:60] = between[-60:] = False
        self.assertGreater(np.quantile(trust[between], 0.1), 0.5)

    def test_rests_between_smooth_moves_make_no_corner_of_them(self):
        # Cycloids of 1 s, then 1.5 s of rest, without noise.
        place = np.clip(TIME % 2.5, 0.0, 1.0)
        step = place - np.sin(2.0 * np.pi * place) / (2.0 * np.pi)
        way = 0.05 * (np.floor(TIME / 2.5) + step)
        moving = (TIME % 2.5 > 0.1) & (TIME % 2.5 < 0.9)
        trust = motion_of(way, 0.0).trust(5.0, 0.02)
        # Where the speed turns round, slopes of a path are less exact.
        self.assertGreater(np.quantile(trust[moving], 0.15), 0.99)

    def test_without_a_mass_no_acceleration_matters(self):
        way = 0.1 * np.abs((TIME / 2.5) % 1.0 - 0.5)
        way = np.convolve(way, np.full(3, 1.0 / 3.0), mode="same")
        trust = motion_of(way).trust(0.0, 0.15)
        self.assertGreater(trust[60:-60].min(), 0.99)


class TestTimes(unittest.TestCase):
    def test_times_in_whole_milliseconds_are_even_again(self):
        even = np.arange(1500) / 128.0
        for rounded in (np.round(even, 3), np.floor(even * 1e3) / 1e3):
            with self.subTest(first=rounded[1]):
                steps = np.diff(without_rounding(rounded))
                np.testing.assert_allclose(steps, 1.0 / 128.0, rtol=1e-4)

    def test_even_times_stay_to_the_last_bit(self):
        for rate in (100.0, 200.0, 1000.0):
            time = np.round(np.arange(800) / rate, 6)
            np.testing.assert_array_equal(without_rounding(time), time)

    def test_a_clock_that_shakes_more_than_its_digits_stays(self):
        shake = 2e-3 * np.random.default_rng(0).uniform(-1.0, 1.0, 800)
        time = np.round(np.arange(800) / 100.0 + shake, 3)
        np.testing.assert_array_equal(without_rounding(time), time)

    def test_a_gap_stays(self):
        for rate, digits in ((128.0, 3), (100.0, 2), (1000.0, 3)):
            even = np.round(np.arange(900) / rate, digits)
            for lost in (slice(300, 340), [450], [200, 500, 700]):
                with self.subTest(rate=rate, lost=lost):
                    time = np.delete(even, lost)
                    found = without_rounding(time)
                    np.testing.assert_array_equal(found, time)


if __name__ == "__main__":
    unittest.main()

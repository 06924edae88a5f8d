"""The cube of channel, phase and band: a gap in one cell is found there."""

import itertools
import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.core.cosine_transform import (
    frequencies_of,
    to_frequency,
    to_time,
)
from brace_drake.identification.gap import RunComparison
from brace_drake.identification.noise_floor import NoiseFloor
from brace_drake.identification.whitening import band_in_time, in_time
from brace_drake.isolation.budget import gap_cells
from brace_drake.isolation.phases import PHASES

RATE, SAMPLES = 200.0, 4000
CHANNELS = ("force_N", "position_m")


def comparison(residual):
    """A run whose prediction is 0, with white noise of 1 N and 1 m."""
    density = np.ones((1, 2))
    floor = NoiseFloor(np.ones(2), np.array([0.0, 500.0]), density)
    weights = floor.weights(SAMPLES, RATE, highest=50.0)
    prepared = SimpleNamespace(
        run=SimpleNamespace(time_s=np.arange(SAMPLES) / RATE),
        measured=residual,
        floor=floor,
        used=np.array([True, True]),
        weights=weights,
    )
    return RunComparison(prepared, np.zeros_like(residual), None)


class TestWhitened(unittest.TestCase):
    def test_a_weighted_residual_keeps_its_squares_in_time(self):
        floor = NoiseFloor(
            np.ones(2), np.array([0.0, 500.0]), np.array([[4.0, 0.25]])
        )
        weights = floor.weights(400, 200.0, highest=50.0)
        prepared = SimpleNamespace(used=np.array([True, True]), weights=weights)
        weighted = np.random.default_rng(1).normal(size=201 * 2)
        series = in_time(prepared, weighted)
        self.assertEqual(series.shape, (201, 2))
        self.assertAlmostEqual(np.sum(series**2), weighted @ weighted)


class TestCube(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(2)
        self.noise = random.normal(size=(SAMPLES, 2))
        self.time = np.arange(SAMPLES) / RATE
        # Five seconds of each phase in turn.
        self.phase = PHASES.index("hold") + (self.time // 5.0).astype(int) % 2

    def cube(self, residual):
        runs = [comparison(residual)]
        return gap_cells(runs, [self.phase], CHANNELS, RATE, 0)

    def test_noise_alone_has_no_content(self):
        self.assertEqual(self.cube(self.noise), [])

    def test_a_gap_in_one_cell_has_its_share_there(self):
        residual = self.noise.copy()
        wave = np.sqrt(2.0) * np.sin(2.0 * np.pi * 4.0 * self.time)
        residual[:, 1] += 3.0 * wave * (self.phase == PHASES.index("loading"))
        first, *others = self.cube(residual)
        self.assertEqual(first["channel"], "position_m")
        self.assertEqual(first["phase"], "loading")
        self.assertEqual((first["from_Hz"], first["to_Hz"]), (2.0, 8.0))
        # A little leaks where the wave is cut off.
        self.assertGreater(first["share"], 0.97)
        self.assertLess(sum(r["share"] for r in others), 0.03)
        self.assertLessEqual(first["lower95"], first["share"])
        self.assertGreaterEqual(first["upper95"], first["share"])
        # 9 over the noise's part of that band, 6 Hz of 100, and noise itself.
        expected = np.sqrt(9.0 / 0.06 + 1.0)
        self.assertAlmostEqual(first["normalised_rms"] / expected, 1, delta=0.1)

    def test_shares_add_up_to_one(self):
        residual = self.noise + 5.0 * np.sin(self.time)[:, None]
        residual[:, 0] += 2.0 * np.sin(60.0 * self.time) ** 3
        total = sum(r["share"] for r in self.cube(residual))
        # Cells with next to nothing are left out.
        self.assertAlmostEqual(total, 1.0, delta=0.02)

    def test_bands_add_up_to_all_that_counts_of_the_residual(self):
        run = comparison(self.noise).prepared
        edges = (0.0, 3.0, 20.0, 50.0)
        parts = [
            band_in_time(run, self.noise, band, RATE)
            for band in itertools.pairwise(edges)
        ]
        counts = (frequencies_of(SAMPLES, RATE) < 50.0)[:, None]
        slow = to_time(to_frequency(self.noise) * counts)
        np.testing.assert_allclose(sum(p[0] for p in parts), slow, atol=1e-9)
        self.assertAlmostEqual(sum(p[1] for p in parts), 0.5, delta=1e-3)


if __name__ == "__main__":
    unittest.main()

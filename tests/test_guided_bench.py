"""A bench whose ring is carried along the way that was recorded."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.bench.imposed_twin import GuidedBenchTwin
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.scenario.brace import BenchScenario
from tests.synthetic_bench import record

STEP = 2e-4
LENGTHS = slice(6, 12)
FRICTION = find_effect("coulomb_friction"), np.array([0.8])


def rms(values):
    """Root of the mean square of all values."""
    return np.sqrt(np.mean(values**2))


class TestGuidedBench(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.twin = BenchTwin(BenchScenario(), STEP)
        cls.guided = GuidedBenchTwin(BenchScenario(), STEP)
        nominal = np.array([p.nominal for p in cls.twin.subject])
        cls.subject = nominal * [1.1, 0.9, 1.05, 1.1, 0.95, 1.1]

    def recorded(self, *uses):
        """A push as the closed loop records it, readings exact."""
        run = record(self.twin, self.subject, (), 1).runs[1]
        log = self.twin.simulate(self.twin.motion(run), self.subject, uses)
        named = dict(zip(self.twin.channels, log.T, strict=True))
        return replace(run, channels=run.channels | named)

    def replay(self, run, *uses):
        """Force, N, and marker, m, on the way of a run (N, 6)."""
        out = self.guided.simulate(self.guided.motion(run), self.subject, uses)
        return out[:, 12:18]

    def off(self, run, *uses):
        """Error of force, N, and marker, m, rms along y."""
        off = self.replay(run, *uses) - self.twin.measured(run)[:, 12:18]
        return rms(off[:, 1]), rms(off[:, 4])

    def test_force_and_marker_on_its_way_are_those_of_the_closed_loop(self):
        run = self.recorded()
        force, marker = self.off(run)
        self.assertGreater(np.ptp(self.twin.measured(run)[:, 13]), 5.0)
        self.assertLess(force, 0.01)
        self.assertLess(marker, 1e-7)

    def test_the_ring_is_where_it_was(self):
        run = self.recorded(FRICTION)
        motion = self.guided.motion(run)
        out = self.guided.simulate(motion, self.subject)
        off = out[:, LENGTHS] - self.twin.measured(run)[:, LENGTHS]
        self.assertLess(rms(off), 2e-6)

    def test_drives_that_stick_are_nothing_on_the_way_that_they_make(self):
        run = self.recorded(FRICTION)
        force, marker = self.off(run)
        loop = self.twin.simulate(self.twin.motion(run), self.subject)
        off = (loop - self.twin.measured(run))[:, [13, 16]]
        self.assertLess(force, 0.01 * rms(off[:, 0]))
        self.assertLess(marker, 0.01 * rms(off[:, 1]))

    def test_an_effect_of_the_contact_shows_and_is_met(self):
        use = find_effect("relaxation"), np.array([4000.0, 0.8])
        run = self.recorded(FRICTION, use)
        self.assertGreater(self.off(run)[0], 10.0 * self.off(run, use)[0])

    def test_noise_is_that_of_force_marker_and_way(self):
        run = self.recorded()
        motion = self.guided.motion(run)
        exact = self.guided.simulate(motion, self.subject)
        noisy = self.guided.simulate(
            motion, self.subject, (), np.random.default_rng(3)
        )
        sigma = self.twin.numbers.noise_sigma
        force, marker = (rms((noisy - exact)[:, c]) for c in (13, 16))
        self.assertGreater(force, sigma[7])
        self.assertLess(force, 3.0 * sigma[7])
        self.assertAlmostEqual(marker, sigma[10], delta=0.1 * sigma[10])

    def test_it_says_nothing_of_commands_lengths_and_virtual_position(self):
        active = self.guided.active(self.recorded())
        self.assertEqual(np.flatnonzero(active).tolist(), list(range(12, 18)))
        free = record(self.twin, self.subject, (), 1).runs[0]
        active = self.guided.active(free)
        self.assertEqual(np.flatnonzero(active).tolist(), [12, 13, 14])


if __name__ == "__main__":
    unittest.main()

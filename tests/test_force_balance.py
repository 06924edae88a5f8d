"""What the balance of the leg forces lacks along a recorded way."""

import unittest

import numpy as np

from brace_drake.devices.bench.force_balance import (
    CUTOFF_HZ,
    MARGIN_S,
    calc_imbalance,
)
from brace_drake.devices.bench.ring_way import follow_ring, slope
from brace_drake.devices.bench.rollout import Motion
from brace_drake.effects.registry import find_effect
from tests.synthetic_bench import MOTIONS, RATE, SyntheticBench


class TestBalance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.twin = SyntheticBench().twin
        cls.subject = np.array([p.nominal for p in cls.twin.subject])

    def lack(self, motion, *uses):
        """Way of the ring and what its balance lacks (N, 6), without ends."""
        touches, desired = MOTIONS[motion]
        log = self.twin.simulate(Motion(desired, touches), self.subject, uses)
        way = follow_ring(self.twin.numbers, log, RATE, CUTOFF_HZ)
        lack = calc_imbalance(self.twin.numbers, way, touches)
        edge = int(MARGIN_S * RATE)
        inner = slice(edge, len(lack) - edge)
        return way, lack[inner], inner

    def test_of_the_twin_itself_it_lacks_next_to_nothing(self):
        for motion in MOTIONS:
            way, lack, inner = self.lack(motion)
            moved = np.ptp(way.commands[inner], axis=0).max()
            self.assertLess(np.abs(lack).max(), 0.03 * moved)

    def test_damping_of_the_drives_lacks_that_times_their_rates(self):
        use = find_effect("viscous_leg"), np.array([40.0])
        way, lack, inner = self.lack("free", use)
        rates = way.leg_rates[inner].ravel()
        found = rates @ lack.ravel() / (rates @ rates)
        self.assertAlmostEqual(found, 40.0, delta=1.0)

    def test_a_weak_leg_lacks_its_share_of_its_command(self):
        use = find_effect("weak_leg"), np.array([3.0, 0.2])
        way, lack, inner = self.lack("free", use)
        command = way.commands[inner, 2]
        found = command @ lack[:, 2] / (command @ command)
        self.assertAlmostEqual(found, 0.2, delta=0.005)
        others = np.delete(lack, 2, axis=1)
        self.assertLess(np.abs(others).max(), 0.03 * np.abs(lack[:, 2]).max())

    def test_mass_of_the_ring_lacks_its_weight_in_sum(self):
        use = find_effect("ring_mass"), np.array([0.1])
        way, lack, inner = self.lack("free", use)
        force = np.linalg.solve(way.unit_forces[inner], lack[:, :, None])
        weight = 0.1 * self.twin.numbers.ring[0, 4]
        weight /= self.twin.numbers.ring[0, 0]
        self.assertAlmostEqual(np.mean(force[:, 2]), weight, delta=0.02)

    def test_a_spline_keeps_the_rates_that_neighbours_lose(self):
        time = np.arange(200) / 20.0
        values = np.sin(2.0 * np.pi * 4.0 * time)
        exact = 8.0 * np.pi * np.cos(2.0 * np.pi * 4.0 * time)
        off = (slope(values, 20.0) - exact)[10:-10]
        self.assertLess(np.abs(off).max(), 0.03 * np.abs(exact).max())


if __name__ == "__main__":
    unittest.main()

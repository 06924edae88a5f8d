"""Phases of a motion that was put together from known ones."""

import unittest

import numpy as np

from brace_drake.devices.declaration import MotionSignals
from brace_drake.isolation.phases import PHASES, motion_phases

RATE = 200.0


def names(phase, times):
    """Phases at some times, s."""
    return [PHASES[phase[round(t * RATE)]] for t in times]


class TestPhases(unittest.TestCase):
    def setUp(self):
        self.time = np.arange(0.0, 8.0, 1.0 / RATE)
        # Still, a push to -10 mm, still, and back.
        knots = [0.0, 2.0, 4.0, 6.0, 8.0], [0.0, 0.0, -0.01, -0.01, 0.0]
        self.position = np.interp(self.time, *knots)
        self.force = 1000.0 * self.position[:, None]

    def phases(self, position=None, touching=None, contact=True, breath=None):
        position = self.position if position is None else position
        signals = MotionSignals(position, 0, touching, position, "ring")
        return motion_phases(signals, self.force, RATE, contact, breath)

    def test_a_push_and_its_way_back_are_told_apart(self):
        found = names(self.phases(), [1.0, 3.0, 5.0, 7.0])
        self.assertEqual(found, ["hold", "loading", "hold", "unloading"])

    def test_without_a_torso_there_is_no_load(self):
        found = names(self.phases(contact=False), [1.0, 3.0, 7.0])
        self.assertEqual(found, ["hold", "free motion", "free motion"])

    def test_a_turn_is_a_reversal(self):
        wave = 0.01 * np.sin(2.0 * np.pi * 0.25 * self.time)
        found = names(self.phases(wave), [1.0, 3.0, 2.0])
        self.assertEqual(found[:2], ["reversal", "reversal"])
        self.assertNotEqual(found[2], "reversal")

    def test_a_lost_pad_is_seen_where_it_goes(self):
        touching = np.column_stack([self.time < 3.0, np.ones(len(self.time))])
        found = names(self.phases(touching=touching), [2.5, 3.0, 3.1, 3.5])
        lost = "contact made or lost"
        self.assertEqual(found, ["loading", lost, lost, "loading"])

    def test_at_rest_a_breath_divides_the_time(self):
        breath = np.sin(2.0 * np.pi * 0.25 * self.time)
        found = names(self.phases(breath=breath), [0.5, 1.5, 3.0, 4.5, 5.5])
        self.assertEqual(
            found,
            [
                "breath rising",
                "breath falling",
                "loading",
                "breath rising",
                "breath falling",
            ],
        )

    def test_a_run_at_rest_is_a_hold(self):
        still = np.zeros_like(self.time)
        self.assertEqual(set(self.phases(still)), {PHASES.index("hold")})


if __name__ == "__main__":
    unittest.main()

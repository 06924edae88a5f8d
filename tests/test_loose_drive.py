"""Tests of drives that stick behind a joint that gives way."""

import unittest

import numpy as np

from brace_drake.effects.actuation.coulomb_friction import STUCK, slip_share
from brace_drake.effects.actuation.loose_drive import (
    run_in_gap,
    yield_elastic,
)

# Step, s; viscous friction of the drive, N s/m; compliance, m/N; dry friction,
# N; half of a gap, m.
DT, DRAG, COMPLIANCE, LEVEL, HALF = 2e-4, 40.0, 1.5e-4, 0.4, 3e-4


class LooseDriveTest(unittest.TestCase):
    def hold_elastic(self, command, rate, steps, level=LEVEL):
        """Stretch and deflection after so many steps at a command."""
        stretch = z = 0.0
        for _ in range(steps):
            stretch, _, z = yield_elastic(
                DT, command, rate, DRAG, COMPLIANCE, level, stretch, z
            )
        return stretch, z

    def test_a_drive_below_its_friction_gives_way_by_its_bristles_alone(self):
        # Bristles of F_c / 10 um and spring 1 / C share the command.
        stretch, z = self.hold_elastic(0.3, 0.0, 5000)
        stiffness = LEVEL / 1e-5
        expected = 0.3 / (stiffness + 1.0 / COMPLIANCE)
        self.assertAlmostEqual(stretch, expected, delta=1e-9)
        self.assertAlmostEqual(z, expected, delta=1e-9)

    def test_beyond_it_the_spring_takes_the_command_less_the_friction(self):
        stretch, _ = self.hold_elastic(2.0, 0.0, 5000)
        self.assertAlmostEqual(stretch, COMPLIANCE * (2.0 - LEVEL), delta=1e-9)

    def test_a_drive_that_is_pulled_along_adds_friction_and_drag(self):
        rate = 0.02
        stretch, _ = self.hold_elastic(0.0, rate, 20000)
        expected = -COMPLIANCE * (LEVEL + DRAG * rate)
        self.assertAlmostEqual(stretch, expected, delta=1e-9)

    def test_bristles_slip_as_those_of_a_drive_that_is_rigidly_joined(self):
        # b v = u - e / C - s_0 z, z' = v (1 - a |z| / z_s), in fine steps.
        top, fine = 1e-5, DT / 100.0
        stretch = z = end = deflection = 0.0
        for i in range(2000):
            command = 0.45 * np.sin(2.0 * np.pi * i * DT / 0.2)
            for _ in range(100):
                held = stretch / COMPLIANCE + LEVEL / top * z
                v = (command - held) / DRAG
                share = slip_share(v, z, top, STUCK)
                stretch += fine * v
                z += fine * v * (1.0 - share * abs(z) / top)
            end, _, deflection = yield_elastic(
                DT, command, 0.0, DRAG, COMPLIANCE, LEVEL, end, deflection
            )
            self.assertAlmostEqual(end, stretch, delta=1e-7)
            self.assertAlmostEqual(deflection, z, delta=2e-7)
        # It has slipped: bristles alone would be back where they began.
        self.assertGreater(abs(stretch - z), 5e-7)

    def test_without_friction_the_stretch_decays_at_the_rate_of_the_spring(
        self,
    ):
        end, mean, _ = yield_elastic(
            DT, 0.0, 0.0, DRAG, COMPLIANCE, 0.0, 1e-3, 0.0
        )
        rate = DT / (COMPLIANCE * DRAG)
        self.assertAlmostEqual(
            end, 1e-3 * 2.718281828459045**-rate, delta=1e-12
        )
        # The mean of a decaying exponential.
        self.assertAlmostEqual(mean, (1e-3 - end) / rate, delta=1e-12)

    def test_a_drive_stands_in_its_gap_below_its_friction(self):
        place = z = passed = 0.0
        for _ in range(5000):
            place, passed, z = run_in_gap(
                DT, 0.25, 0.0, DRAG, HALF, LEVEL, place, z
            )
        self.assertAlmostEqual(place, 0.25 / LEVEL * 1e-5, delta=1e-9)
        self.assertEqual(passed, 0.0)

    def test_it_crosses_the_gap_at_the_speed_that_friction_leaves(self):
        place = z = 0.0
        steps = 20
        for _ in range(200):
            place, _, z = run_in_gap(DT, 1.2, 0.0, DRAG, HALF, LEVEL, place, z)
            if z >= 1e-5:
                break
        before = place
        for _ in range(steps):
            place, _, z = run_in_gap(DT, 1.2, 0.0, DRAG, 1.0, LEVEL, place, z)
        speed = (place - before) / (steps * DT)
        self.assertAlmostEqual(speed, (1.2 - LEVEL) / DRAG, delta=1e-9)

    def test_at_the_end_of_its_gap_it_passes_what_friction_leaves(self):
        place, z, passed = HALF, 0.0, 0.0
        for _ in range(2000):
            # The ring runs away slowly, the drive behind it.
            place, passed, z = run_in_gap(
                DT, 1.2, 1e-3, DRAG, HALF, LEVEL, place, z
            )
        self.assertEqual(place, HALF)
        self.assertAlmostEqual(passed, 1.2 - LEVEL - DRAG * 1e-3, delta=1e-9)


if __name__ == "__main__":
    unittest.main()

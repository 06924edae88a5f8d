"""Pads, posture and readings by hand."""

import math
import unittest

import numpy as np

from brace_drake.laws import contact, posture
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.ticks import round_readings, run_forces
from brace_drake.laws.plug_in import make_effects
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench

# Stiffness, damping, friction, regularisation speed, pad offset, preload.
LAW = np.array([6400.0, 150.0, 0.35, 0.005, 0.15, 0.001])


def two_bodies(p_R=(0, 0, 0), v_R=(0, 0, 0)):
    bodies = np.zeros(26)
    bodies[0] = bodies[7] = 1.0
    bodies[4:7], bodies[17:20] = p_R, v_R
    return bodies


def press(bodies):
    """Spatial forces on ring and torso, and the force on the torso."""
    numbers = pack_bench(BenchScenario()).with_changes(
        contact=LAW[None], posture=np.zeros(15)
    )
    brace = make_brace(numbers, with_torso=True, with_legs=False)
    brace.bodies[:] = bodies
    next(run_forces(1e-3, np.zeros(1), numbers, make_effects({}, 1), brace))
    return brace.F[0], brace.F[1], brace.f_T[0]


class TestPads(unittest.TestCase):
    def test_preloaded_pads_balance_at_rest(self):
        F_R, F_T, f_T = press(two_bodies())
        for F in (F_R, F_T, f_T):
            np.testing.assert_allclose(F, 0.0, atol=1e-12)

    def test_a_shift_presses_with_both_pads_until_one_lifts(self):
        # d = 0.0015 and 0.0005: 6400 * 0.001. Beyond 1 mm, one pad alone.
        _, _, f_T = press(two_bodies((0, -0.0005, 0)))
        self.assertAlmostEqual(f_T[1], -6.4, places=10)
        _, _, f_T = press(two_bodies((0, -0.002, 0)))
        self.assertAlmostEqual(f_T[1], -6400 * 0.003, places=10)

    def test_damping_adds_to_both_pads(self):
        _, _, f_T = press(two_bodies(v_R=(0, -0.01, 0)))
        self.assertAlmostEqual(f_T[1], -2 * 150 * 0.01, places=10)

    def test_a_pad_never_pulls(self):
        # +y pad: 6.4 - 150 * 0.1 < 0; -y pad: 6.4 + 15.
        _, _, f_T = press(two_bodies(v_R=(0, 0.1, 0)))
        self.assertAlmostEqual(f_T[1], 21.4, places=10)

    def test_friction_drags_the_torso_along(self):
        _, _, f_T = press(two_bodies(v_R=(0.01, 0, 0)))
        drag = 2 * 0.35 * 6.4 * math.tanh(0.01 / 0.005)
        self.assertAlmostEqual(f_T[0], drag, places=10)

    def test_forces_are_equal_and_opposite_at_the_pads_centre(self):
        bodies = two_bodies((0.001, -0.0005, 0.002), (0.01, 0.002, -0.01))
        bodies[0:4] = [0.999, 0.01, 0.02, 0.03]
        bodies[0:4] /= np.linalg.norm(bodies[0:4])
        F_R, F_T, f_T = press(bodies)
        np.testing.assert_allclose(F_R[3:6], -F_T[3:6], atol=1e-12)
        np.testing.assert_allclose(F_T[3:6], f_T, atol=1e-12)
        # About one point the torques cancel as well.
        moved = F_R[0:3] + np.cross(bodies[4:7], F_R[3:6])
        np.testing.assert_allclose(moved, -F_T[0:3], atol=1e-12)

    def test_the_law_is_spring_and_damper(self):
        self.assertEqual(contact.normal_force(0.002, -0.01, 6400, 150), 11.3)


class TestPosture(unittest.TestCase):
    def test_spring_damper_and_lean_act_along_the_axes_of_w(self):
        law = np.append(np.arange(1.0, 13.0), [100.0, 200.0, 300.0])
        F = np.zeros(6)
        posture.add_posture_force(
            np.array([0.1, 0.2, 0.3]),
            np.array([0.01, 0.02, 0.03]),
            np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            law,
            F,
        )
        np.testing.assert_allclose(F[3:6], [83.9, 174.6, 263.1])
        np.testing.assert_allclose(F[0:3], [-10.07, -22.16, -36.27])


class TestReading(unittest.TestCase):
    def test_noise_comes_before_rounding(self):
        readings = np.full(12, 0.1234)
        round_readings(np.array([0.001, 0.01]), np.full(12, 0.0008), readings)
        expected = [*[0.124] * 6, *[0.12] * 3, *[0.1242] * 3]
        np.testing.assert_allclose(readings, expected, rtol=1e-12)

    def test_no_resolution_means_no_rounding(self):
        readings = np.full(12, 0.5)
        round_readings(np.zeros(2), np.full(12, 0.25), readings)
        np.testing.assert_array_equal(readings, 0.75)


if __name__ == "__main__":
    unittest.main()

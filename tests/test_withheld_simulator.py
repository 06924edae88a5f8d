"""The simulator of the bench against closed forms and the shared recordings."""

import math
import unittest

import numpy as np

from brace_drake.withheld.faults import FAULTS, OUTSIDE
from brace_drake.withheld.simulator import (
    COLUMNS,
    Flaws,
    Subject,
    legs,
    make_motions,
    numbers,
    pads,
    run_bench,
    with_flaws,
)
from brace_drake.withheld.simulator.flaws import PadFlaws
from brace_drake.withheld.simulator.frame import find_pose, leg_geometry
from brace_drake.withheld.simulator.motions import between_samples
from brace_drake.withheld.simulator.turning import exponential, logarithm
from tests.shared_data import SHARED, needs_shared


def still(seconds):
    """A reference that stays where it is."""
    return np.zeros((round(seconds / numbers.TICK), 3))


def ideal(wanted, flaws=None, contact=True, subject=None):
    """A run with ideal instruments."""
    return run_bench(
        wanted,
        contact,
        subject or Subject(),
        flaws or Flaws(),
        np.random.default_rng(0),
        False,
    )


class TestMechanics(unittest.TestCase):
    def test_the_logarithm_undoes_the_exponential(self):
        for a in ([0.3, -0.2, 0.9], [1e-5, 2e-6, -3e-5], [0.0, 0.0, 0.0]):
            R, found = np.empty((3, 3)), np.empty(3)
            exponential(np.array(a), R)
            logarithm(R, found)
            np.testing.assert_allclose(found, a, atol=1e-14)
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)

    def test_the_pose_is_found_from_its_leg_lengths(self):
        lower, upper = numbers.lower_joints(), numbers.upper_joints()
        p, R = np.array([0.004, -0.009, 0.236]), np.empty((3, 3))
        exponential(np.array([0.01, -0.02, 0.03]), R)
        length = np.empty(6)
        leg_geometry(
            p, R, lower, upper, length, np.empty((6, 3)), np.empty((6, 3))
        )
        p_found, R_found = np.array([0.0, 0.0, 0.235]), np.eye(3)
        find_pose(length, p_found, R_found, lower, upper)
        np.testing.assert_allclose(p_found, p, atol=1e-12)
        np.testing.assert_allclose(R_found, R, atol=1e-12)

    def test_a_perfect_bench_at_rest_stays_at_rest(self):
        log = ideal(still(0.5))
        # Six alike legs carry the weight.
        np.testing.assert_allclose(log - log[0], 0.0, atol=1e-9)

    def test_the_legs_carry_the_weight(self):
        lower, upper = numbers.lower_joints(), numbers.upper_joints()
        length, along = np.empty(6), np.empty((6, 3))
        p = np.array([0.0, 0.0, numbers.RING_HEIGHTS[1]])
        leg_geometry(
            p, np.eye(3), lower, upper, length, np.empty((6, 3)), along
        )
        held = ideal(still(0.1))[-1, :6] @ along
        weight = numbers.RING_MASS * numbers.GRAVITY
        np.testing.assert_allclose(held, [0.0, 0.0, weight], atol=1e-9)

    def test_a_torso_let_go_loses_its_energy(self):
        # Posture shifts at once; from then on springs and dampers are alone.
        flaws = with_flaws(
            Flaws(), {"torso.creep": 2e-3, "torso.creep_time": 1e-3}
        )
        y = ideal(still(6.0), flaws)[:, 16]
        rest = y[-1]
        swings = [
            np.max(np.abs(y[i : i + 200] - rest)) for i in range(0, 1000, 200)
        ]
        self.assertTrue(np.all(np.diff(swings) < 0.0), swings)


class TestFriction(unittest.TestCase):
    def test_it_sticks_below_breakaway_without_creep(self):
        # A shaking load below break-away moves the bristle to and fro only.
        stiffness = legs.bristle_stiffness(1.0, 0.0)
        z, x, h = 0.0, 0.0, 1e-5
        for i in range(20000):
            v = 1e-3 * math.cos(2 * math.pi * 100.0 * i * h)
            rate = legs.bristle_rate(v, z, 1.0, stiffness)
            z, x = z + h * rate, x + h * v
        self.assertAlmostEqual(z, x, delta=1e-12)

    def test_it_slides_at_the_stribeck_curve(self):
        sliding = legs.sliding_friction(2e-3, 1.0, 0.5, 1e-3, 2.0)
        self.assertAlmostEqual(sliding, 1.0 + 0.5 * math.exp(-4.0))
        stiffness = legs.bristle_stiffness(1.0, 0.5)
        z, h = 0.0, 1e-6
        for _ in range(100000):
            z += h * legs.bristle_rate(2e-3, z, sliding, stiffness)
        force = legs.friction(z, 0.0, stiffness)
        self.assertAlmostEqual(force, sliding, places=6)


class TestTissue(unittest.TestCase):
    def test_a_held_pad_relaxes_as_its_maxwell_arms_say(self):
        flaws = PadFlaws(arm=3000.0, arm_time=0.5)
        d, h, steps = 1e-3, 1e-4, 5000
        memory, rate = np.zeros(3), np.zeros(3)
        pads.start_memory(d, flaws, memory)
        for _ in range(steps):
            force = pads.press(d, 0.0, Subject(), flaws, memory, rate, 0)
            memory += h * rate
        t = h * (steps - 1)
        arms = 0.9 * math.exp(-t / 0.5) + 0.1 * math.exp(-t / 0.1)
        expected = 6400.0 * d + 3000.0 * d * arms
        # Explicit Euler errs by about h / (2 tau) of the arms.
        self.assertAlmostEqual(force, expected, delta=1e-3)

    def test_a_pad_never_pulls(self):
        memory, rate = np.zeros(3), np.zeros(3)
        for d, d_rate in ((1e-3, -1.0), (-1e-4, 0.0), (0.0, 1.0)):
            force = pads.press(
                d, d_rate, Subject(), PadFlaws(), memory, rate, 0
            )
            self.assertEqual(force, 0.0)

    def test_a_loop_of_hysteresis_loses_energy(self):
        flaws = PadFlaws(loop=1.0, loop_width=1e-4)
        memory, rate = np.zeros(3), np.zeros(3)
        work, h = 0.0, 1e-4
        for i in range(20000):
            t = i * h
            d = 2e-3 + 1e-3 * math.sin(2 * math.pi * t)
            v = 2e-3 * math.pi * math.cos(2 * math.pi * t)
            pads.press(d, 0.0, Subject(), flaws, memory, rate, 0)
            pads.press(d, v, Subject(), flaws, memory, rate, 0)
            memory += h * rate
            if t >= 1.0:
                work += h * v * flaws.loop * memory[2]
        # An ideal loop of +-1 N over 2 mm and back takes 4 mJ.
        self.assertGreater(work, 0.8 * 4e-3)
        self.assertLess(work, 4e-3)


class TestMotions(unittest.TestCase):
    def test_logged_derivatives_are_those_of_the_motion(self):
        for motion in make_motions(np.random.default_rng(3)):
            y, v, a = motion.samples.T
            h = 5e-3
            # The trapezoidal rule errs by h^2 / 12 of the bend; jumps of the
            # acceleration at the ends of ramps by h a / 2 each.
            np.testing.assert_allclose(
                np.diff(y), h * (v[1:] + v[:-1]) / 2, atol=5e-6
            )
            np.testing.assert_allclose(
                np.diff(v), h * (a[1:] + a[:-1]) / 2, atol=1e-3
            )

    def test_the_fine_reference_meets_its_samples(self):
        motion = make_motions(np.random.default_rng(4))[0]
        fine = between_samples(motion.samples)
        np.testing.assert_array_equal(fine[::5], motion.samples)

    def test_the_repeat_repeats(self):
        motions = {m.name: m for m in make_motions(np.random.default_rng(5))}
        np.testing.assert_array_equal(
            motions["push"].wanted, motions["push_repeat"].wanted
        )


class TestFaults(unittest.TestCase):
    def test_every_fault_shows_and_more_so_the_stronger_it_is(self):
        motions = {m.name: m for m in make_motions(np.random.default_rng(0))}
        wanted = motions["stairs"].wanted[2000:5000]
        healthy = ideal(wanted)
        for fault in (*FAULTS, *OUTSIDE):
            sizes = []
            for strength in (fault.strengths[0], fault.strengths[2]):
                change = fault.make(np.random.default_rng(1), strength)
                if "legs.limit" in change:
                    change = {"legs.limit": 6.0 * strength}
                log = ideal(wanted, with_flaws(Flaws(), change))
                self.assertTrue(np.all(np.isfinite(log)), fault.name)
                gap = (log - healthy) / np.std(healthy, axis=0)
                sizes.append(float(np.sqrt(np.mean(gap**2))))
            with self.subTest(fault=fault.name, sizes=sizes):
                self.assertGreater(sizes[1], sizes[0])

    def test_the_same_seed_gives_the_same_recording(self):
        wanted = still(0.2)
        runs = [
            run_bench(
                wanted, True, Subject(), Flaws(), np.random.default_rng(seed)
            )
            for seed in (1, 1, 2)
        ]
        np.testing.assert_array_equal(runs[0], runs[1])
        self.assertTrue(np.any(runs[0] != runs[2]))


class TestAgreement(unittest.TestCase):
    @needs_shared("campaigns/open00_nominal")
    def test_with_nothing_wrong_it_is_the_nominal_bench_to_its_noise(self):
        from brace_drake.recording import LoadCampaign

        folder = SHARED / "campaigns" / "open00_nominal"
        # Every other run: free, held, pushed and shaken.
        for i, run in enumerate(LoadCampaign(folder).runs[::2]):
            reference = run.stack(
                (
                    "ring2_y_desired_m",
                    "ring2_vy_desired_m_s",
                    "ring2_ay_desired_m_s2",
                )
            )
            wanted = between_samples(reference)
            quiet, noisy = (
                run_bench(
                    wanted,
                    run.contact,
                    Subject(),
                    Flaws(),
                    np.random.default_rng(i),
                    noise,
                )
                for noise in (False, True)
            )
            rest = np.sqrt(np.mean((run.stack(COLUMNS) - quiet) ** 2, axis=0))
            floor = np.sqrt(np.mean((noisy - quiet) ** 2, axis=0))
            with self.subTest(run=run.name):
                # 2400 samples tell a root mean square to about 2 %; the
                # virtual position wanders slowly, so its is told worse.
                self.assertLess(np.max(rest[:-1] / floor[:-1]), 1.08)
                self.assertLess(rest[-1], 2.0 * floor[-1])


if __name__ == "__main__":
    unittest.main()

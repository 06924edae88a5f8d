"""Tests of the network that starts the fit of the contact."""

import subprocess
import sys
import unittest

import numpy as np
import torch

from brace_drake.core.errors import CampaignError, FitError
from brace_drake.identification.subject.contact_start import (
    contact_motion_from_run,
    signed_compression,
)
from brace_drake.identification.subject.nn_regression import fit_contact_nn
from brace_drake.recording.recording import Run
from tests.nn_comparison import (
    compare_discretisations,
    push_record,
)

K = 6400.0
C = 150.0
M = 40.0


def sine_record(frequency_hz, interval_s, mass):
    """y = 1 mm sin(w t) and the exact force of m y'' + c y' + k y = F."""
    w = 2.0 * np.pi * frequency_hz
    time = np.arange(0.0, 4.0, interval_s)
    y = 1e-3 * np.sin(w * time)
    force = (K - mass * w**2) * y + C * w * 1e-3 * np.cos(w * time)
    return time, y, force


def acceleration_image(y, interval_s):
    """(alpha, beta) of D2 y/dt^2 = alpha y + beta D y/dt, by least squares."""
    second = (y[2:] - 2.0 * y[1:-1] + y[:-2]) / interval_s**2
    first = (y[2:] - y[1:-1]) / interval_s
    regressors = np.column_stack([y[2:], first])
    return np.linalg.lstsq(regressors, second, rcond=None)[0]


def make_run(channels, contact=True):
    """A run that holds just these channels."""
    return Run("push.csv", contact, "push", None, "fit", channels)


class ClosedFormTest(unittest.TestCase):
    """On a sine y(j-2) = 2 cos(p) y(j-1) - y(j), p = w dt: fits are exact."""

    def test_consistent_form_returns_closed_form_of_a_sine(self):
        for interval, mass in ((0.05, M), (0.05, 0.0), (0.01, M)):
            with self.subTest(interval=interval, mass=mass):
                w = 2.0 * np.pi * 1.1
                half = w * interval / 2.0
                chord = 2.0 * mass * (1.0 - np.cos(2.0 * half))
                estimate = fit_contact_nn(
                    *sine_record(1.1, interval, mass),
                    mass,
                    discretisation="consistent",
                )
                k = K - mass * w**2 - C * w * np.tan(half)
                k += chord / interval**2
                c = C * 2.0 * half / np.sin(2.0 * half) - chord / interval
                # Rounding and the optimiser's tolerance only.
                np.testing.assert_allclose(estimate.stiffness, k, rtol=1e-6)
                np.testing.assert_allclose(estimate.damping, c, rtol=1e-5)
                self.assertLess(estimate.rmse_N, 1e-6)

    def test_printed_form_returns_apparent_stiffness_over_the_interval(self):
        w = 2.0 * np.pi * 1.1
        for interval in (0.05, 0.01):
            with self.subTest(interval=interval):
                half = w * interval / 2.0
                chord = 2.0 * M * (1.0 - np.cos(2.0 * half))
                estimate = fit_contact_nn(
                    *sine_record(1.1, interval, M),
                    M,
                    discretisation="printed",
                )
                k = K - M * w**2 - C * w * np.tan(half) + chord
                c = C * w / np.sin(2.0 * half) - chord
                np.testing.assert_allclose(
                    estimate.stiffness, k / interval, rtol=1e-6
                )
                np.testing.assert_allclose(estimate.damping, c, rtol=1e-5)

    def test_both_forms_agree_at_an_interval_of_one_second(self):
        time = np.arange(0.0, 40.0, 1.0)
        w = 2.0 * np.pi * 0.13
        y = 1e-3 * np.sin(w * time)
        force = (K - M * w**2) * y + C * w * 1e-3 * np.cos(w * time)
        one, other = (
            fit_contact_nn(time, y, force, M, discretisation=d)
            for d in ("printed", "consistent")
        )
        self.assertAlmostEqual(one.stiffness, other.stiffness, places=6)
        self.assertAlmostEqual(one.damping, other.damping, places=6)


class RecoveryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rows = compare_discretisations(intervals_s=(0.05, 0.004, 0.002))
        cls.rows = {
            (r.mass, r.interval_s, r.estimate.discretisation): r for r in rows
        }

    def test_table_has_a_row_for_every_case(self):
        self.assertEqual(len(self.rows), 2 * 3 * 2)

    def test_consistent_form_recovers_a_massless_contact_at_50_ms(self):
        row = self.rows[0.0, 0.05, "consistent"]
        # Measured -0.02 % and -2.0 %: the differences' error at 1.7 Hz.
        self.assertLess(abs(row.stiffness_error), 0.001)
        self.assertLess(abs(row.damping_error), 0.03)

    def test_consistent_form_recovers_k_at_50_ms_but_not_c_with_mass(self):
        row = self.rows[M, 0.05, "consistent"]
        # Measured +0.35 %; c is -34 N s/m, off by about -m w^2 dt.
        self.assertLess(abs(row.stiffness_error), 0.005)
        self.assertLess(row.estimate.damping, 0.0)

    def test_consistent_form_recovers_both_at_fine_intervals(self):
        massless = self.rows[0.0, 0.002, "consistent"]
        self.assertLess(abs(massless.stiffness_error), 1e-4)
        self.assertLess(abs(massless.damping_error), 1e-3)
        # Measured +0.01 % and -4.9 %.
        heavy = self.rows[M, 0.002, "consistent"]
        self.assertLess(abs(heavy.stiffness_error), 1e-3)
        self.assertLess(abs(heavy.damping_error), 0.06)

    def test_consistent_form_converges_with_first_order(self):
        coarse = self.rows[M, 0.004, "consistent"]
        fine = self.rows[M, 0.002, "consistent"]
        for name in ("stiffness_error", "damping_error"):
            with self.subTest(name):
                ratio = getattr(coarse, name) / getattr(fine, name)
                # 2 up to the next order, w dt = 4 %.
                self.assertAlmostEqual(ratio, 2.0, delta=0.1)

    def test_printed_form_is_off_by_the_interval_without_mass(self):
        for interval in (0.05, 0.004, 0.002):
            with self.subTest(interval=interval):
                printed = self.rows[0.0, interval, "printed"].estimate
                consistent = self.rows[0.0, interval, "consistent"].estimate
                np.testing.assert_allclose(
                    [printed.stiffness, printed.damping],
                    np.array([consistent.stiffness, consistent.damping])
                    / interval,
                    rtol=1e-5,
                )

    def test_printed_form_follows_its_identity_with_mass(self):
        for interval in (0.05, 0.004):
            with self.subTest(interval=interval):
                y, _ = push_record(np.arange(0.0, 12.0, interval), K, C, M)
                images = acceleration_image(y, interval)
                printed = self.rows[M, interval, "printed"].estimate
                consistent = self.rows[M, interval, "consistent"].estimate
                expected = (
                    np.array(
                        [
                            consistent.least_squares_stiffness,
                            consistent.least_squares_damping,
                        ]
                    )
                    + M * (1.0 - interval**2) * images
                ) / interval
                np.testing.assert_allclose(
                    [
                        printed.least_squares_stiffness,
                        printed.least_squares_damping,
                    ],
                    expected,
                    rtol=1e-6,
                )

    def test_printed_form_does_not_recover_k_and_c(self):
        # Measured: k 20 times too large at 50 ms, 499 times at 2 ms.
        coarse = self.rows[M, 0.05, "printed"]
        fine = self.rows[M, 0.002, "printed"]
        self.assertGreater(coarse.stiffness_error, 18.0)
        self.assertGreater(coarse.damping_error, 5.0)
        self.assertGreater(fine.stiffness_error, 490.0)
        self.assertGreater(fine.damping_error, 400.0)

    def test_noise_beyond_the_motion_sends_c_to_minus_half_k_dt(self):
        generator = np.random.default_rng(3)
        time = np.arange(0.0, 200.0, 0.05)
        y = -1e-3 + 2e-5 * generator.standard_normal(time.size)
        force = np.full(time.size, -1e-3 * K)
        estimate = fit_contact_nn(
            time, y, force, 0.0, discretisation="consistent"
        )
        self.assertAlmostEqual(estimate.stiffness / K, 1.0, delta=0.002)
        # 4000 samples: three standard errors of the slope are 5 %.
        self.assertAlmostEqual(estimate.damping, -K * 0.025, delta=8.0)


class NetworkTest(unittest.TestCase):
    def setUp(self):
        self.time = np.arange(0.0, 12.0, 0.05)

    def fit(self, mass=0.0, sign=1.0, **options):
        y, force = push_record(self.time, K, C, mass)
        options = {"discretisation": "consistent"} | options
        return fit_contact_nn(
            self.time, sign * y, sign * force, mass, **options
        )

    def test_network_equals_least_squares_while_the_relu_is_on(self):
        estimate = self.fit()
        self.assertEqual(estimate.active, 1.0)
        self.assertAlmostEqual(
            estimate.stiffness / estimate.least_squares_stiffness,
            1.0,
            places=8,
        )
        self.assertAlmostEqual(
            estimate.damping / estimate.least_squares_damping, 1.0, places=6
        )

    def test_network_equals_least_squares_of_the_samples_it_is_on(self):
        # The printed form misses this record, so the ReLU is off at some.
        estimate = self.fit(M, discretisation="printed")
        self.assertLess(estimate.active, 1.0)
        y, force = push_record(self.time, K, C, M)
        target = force[2:] - M * y[:-2]
        inputs = np.column_stack([y[2:], y[1:-1]])
        on = np.sign(target) * (inputs @ [estimate.a, estimate.b]) > 0.0
        self.assertAlmostEqual(on.mean(), estimate.active)
        a, b = np.linalg.lstsq(inputs[on], target[on], rcond=None)[0]
        np.testing.assert_allclose([estimate.a, estimate.b], [a, b], rtol=1e-6)

    def test_weights_sum_to_a_and_b_of_the_chosen_discretisation(self):
        estimate = self.fit(M)
        k, c = estimate.stiffness, estimate.damping
        a, b = M / 0.05**2 + c / 0.05 + k, -(2.0 * M / 0.05**2 + c / 0.05)
        np.testing.assert_allclose([estimate.a, estimate.b], [a, b])
        estimate = self.fit(M, discretisation="printed")
        k, c = estimate.stiffness, estimate.damping
        np.testing.assert_allclose(
            [estimate.a, estimate.b], [M + c + k * 0.05, -2.0 * M - c]
        )

    def test_direction_of_the_push_does_not_matter(self):
        self.assertEqual(self.fit(M).stiffness, self.fit(M, -1.0).stiffness)
        self.assertEqual(self.fit(M).damping, self.fit(M, -1.0).damping)

    def test_every_seed_and_width_finds_the_same_minimum(self):
        reference = self.fit(M)
        # A single unit of seed 17 or 45 starts with the ReLU off everywhere.
        cases = ((1, 17), (1, 45), (10, 1), (10, 2), (50, 3), (3, 4))
        for hidden, seed in cases:
            with self.subTest(hidden=hidden, seed=seed):
                estimate = self.fit(M, hidden=hidden, seed=seed)
                self.assertAlmostEqual(
                    estimate.stiffness, reference.stiffness, delta=0.01
                )
                self.assertAlmostEqual(
                    estimate.damping, reference.damping, delta=0.01
                )

    def test_same_seed_gives_the_identical_estimate(self):
        self.assertEqual(self.fit(seed=7), self.fit(seed=7))
        self.assertNotEqual(self.fit(seed=7).a, self.fit(seed=8).a)

    def test_threads_and_global_random_state_are_left_alone(self):
        before = torch.get_num_threads()
        torch.set_num_threads(2)
        state = torch.random.get_rng_state()
        try:
            self.fit()
            self.assertEqual(torch.get_num_threads(), 2)
            self.assertTrue(torch.equal(state, torch.random.get_rng_state()))
        finally:
            torch.set_num_threads(before)

    def test_importing_the_modules_does_not_import_torch(self):
        code = (
            "import sys, brace_drake.identification.subject.nn_regression; "
            "sys.exit('torch' in sys.modules)"
        )
        done = subprocess.run([sys.executable, "-c", code], check=False)
        self.assertEqual(done.returncode, 0)

    def test_unusable_records_and_options_raise_and_say_why(self):
        t = np.arange(8.0)
        y = np.sin(t)
        uneven = np.r_[t[:-1], 9.0]
        cases = {
            "common length": (t, y[:-1], y, 1.0, {}),
            "at least 5": (t[:4], y[:4], y[:4], 1.0, {}),
            "not finite": (t, y * np.nan, y, 1.0, {}),
            "evenly spaced": (uneven, y, y, 1.0, {}),
            "no force or no motion": (t, y * 0.0, y, 0.0, {}),
            "no motion": (t, np.ones(8), y, 0.0, {}),
            "no force": (t, y, y * 0.0, 0.0, {}),
            "mass is": (t, y, y, -1.0, {}),
            "hidden is": (t, y, y, 1.0, {"hidden": 0}),
            "expected one of": (t, y, y, 1.0, {"discretisation": "tustin"}),
        }
        for words, (time, motion, force, mass, options) in cases.items():
            with (
                self.subTest(words),
                self.assertRaisesRegex(FitError, words),
            ):
                options = {"discretisation": "printed"} | options
                fit_contact_nn(time, motion, force, mass, **options)


class ContactMotionTest(unittest.TestCase):
    PRELOAD = 1e-3

    def setUp(self):
        """A push to r = -2.2 mm: both pads first, then one alone."""
        self.time = np.arange(0.0, 12.0, 0.005)
        w = 2.0 * np.pi * 0.5
        push = self.time / 12.0
        ripple = 2e-4 * np.sin(w * self.time)
        self.r = -2e-3 * (3.0 * push**2 - 2.0 * push**3) + ripple
        rate = -2e-3 * 6.0 * (push - push**2) / 12.0
        rate += 2e-4 * w * np.cos(w * self.time)
        # The contact law of bench.md, pad by pad.
        self.force = np.zeros_like(self.r)
        for s in (1.0, -1.0):
            depth = self.PRELOAD - s * self.r
            normal = np.maximum(0.0, K * depth - s * C * rate)
            self.force -= s * np.where(depth > 0.0, normal, 0.0)
        self.rate = rate

    def run_of(self, **changes):
        torso = 3e-3 * np.sin(self.time)
        channels = {
            "time_s": self.time,
            "torso_y_m": torso,
            "ring2_force_y_N": self.force,
        }
        channels |= changes
        return make_run(channels), torso + self.r

    def test_one_spring_and_damper_stands_for_both_regimes(self):
        u = signed_compression(self.r, self.PRELOAD)
        both = np.abs(self.r) < self.PRELOAD
        self.assertTrue(0.2 < both.mean() < 0.8)
        law = K * u + C * self.rate * np.where(both, 2.0, 1.0)
        # The withdrawn pad lifts while k d < -c d', never by more than this.
        bound = C * np.abs(self.rate).max()
        near = np.abs(np.abs(self.r) - self.PRELOAD) < bound / K
        np.testing.assert_allclose(self.force[~near], law[~near], atol=1e-12)
        self.assertLess(np.abs(self.force - law).max(), bound)

    def test_a_push_towards_minus_y_is_negative_and_a_gap_is_free(self):
        r = np.array([-3e-3, -5e-4, 0.0, 5e-4, 3e-3])
        np.testing.assert_allclose(
            signed_compression(r, 1e-3), [-4e-3, -1e-3, 0.0, 1e-3, 4e-3]
        )
        np.testing.assert_allclose(
            signed_compression(r, -1e-3), [-2e-3, 0.0, 0.0, 0.0, 2e-3]
        )

    def test_known_stiffness_and_damping_come_back_from_a_recording(self):
        run, ring_y = self.run_of()
        motion = contact_motion_from_run(run, ring_y, preload_m=self.PRELOAD)
        self.assertEqual(motion.time_s.size, 240)
        estimate = fit_contact_nn(
            motion.time_s,
            motion.compression_m,
            motion.force_N,
            0.0,
            discretisation="consistent",
        )
        # Measured +0.02 % and +0.5 %.
        self.assertAlmostEqual(estimate.stiffness / K, 1.0, delta=0.002)
        self.assertAlmostEqual(estimate.damping / C, 1.0, delta=0.03)

    def test_block_means_keep_a_ramp_and_its_times(self):
        run, _ = self.run_of(ring2_force_y_N=5.0 * self.time)
        motion = contact_motion_from_run(
            run, run.channels["torso_y_m"], preload_m=0.0, resample_s=0.02
        )
        np.testing.assert_allclose(motion.force_N, 5.0 * motion.time_s)
        np.testing.assert_allclose(np.diff(motion.time_s), 0.02)

    def test_unusable_recordings_raise_and_name_the_file(self):
        run, ring_y = self.run_of()
        free = make_run(run.channels, contact=False)
        bare = make_run({"time_s": self.time, "torso_y_m": ring_y})
        keep = np.abs(self.time - 6.0) > 0.1
        gap = make_run({n: c[keep] for n, c in run.channels.items()})
        cases = {
            "free run": (free, ring_y, 0.05),
            "ring2_force_y_N": (bare, ring_y, 0.05),
            "shape": (run, ring_y[:-1], 0.05),
            "shorter than": (run, ring_y, 0.001),
            "no sample": (gap, ring_y[keep], 0.05),
        }
        for words, (record, y, resample) in cases.items():
            with (
                self.subTest(words),
                self.assertRaisesRegex(CampaignError, f"push.csv.*{words}"),
            ):
                contact_motion_from_run(
                    record, y, preload_m=1e-3, resample_s=resample
                )


if __name__ == "__main__":
    unittest.main()

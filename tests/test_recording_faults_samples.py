"""Faults of samples, clocks and of what a manifest says, without a twin."""

import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording_faults import check_recording
from brace_drake.recording_faults.channels import declared
from brace_drake.recording_faults.check import without_false_repeats
from brace_drake.recording_faults.library.channels.outliers import outliers_of
from brace_drake.recording_faults.library.runs.copied_run import find_copies
from brace_drake.recording_faults.library.time.held_channel import interval_of
from brace_drake.recording_faults.library.time.repeated_samples import (
    find_repeated,
)
from brace_drake.recording_faults.statistics import (
    local_error,
    robust_deviation,
)

RATE, SAMPLES = 200.0, 1200


def make_run(name, depth=0.008, seed=0, **about):
    """A push by a smooth reference, with readings that follow and shake."""
    noise = np.random.default_rng(seed)
    t = np.arange(SAMPLES) / RATE
    w = 2.0 * np.pi / t[-1]
    columns = {"time_s": t}
    y = -0.5 * depth * (1.0 - np.cos(w * t))
    columns["ring2_y_desired_m"] = y
    columns["ring2_vy_desired_m_s"] = -0.5 * depth * w * np.sin(w * t)
    columns["ring2_ay_desired_m_s2"] = -0.5 * depth * w * w * np.cos(w * t)
    columns["ring2_y_virtual_m"] = 0.8 * y
    for k in range(1, 7):
        shake = noise.standard_normal((2, SAMPLES))
        columns[f"leg{k}_force_command_N"] = 2.0 + 100 * k * y + 0.04 * shake[0]
        columns[f"leg{k}_length_m"] = np.round(0.14 + y + 5e-6 * shake[1], 5)
    for axis, size in zip("xyz", (10.0, 900.0, 20.0), strict=True):
        shake = noise.standard_normal((2, SAMPLES))
        columns[f"ring2_force_{axis}_N"] = size * y + 0.03 * shake[0]
        columns[f"torso_{axis}_m"] = 5e-4 * size * y + 5e-5 * shake[1]
    about = {"contact": True, "repeat_of": None, "split": "fit", **about}
    return Run(f"{name}.csv", motion=name, channels=columns, **about)


def campaign_of(*runs):
    return Campaign(Path("made"), "bench stage 2", RATE, "made", tuple(runs))


def changed(run, **columns):
    return replace(run, channels={**run.channels, **columns})


class TestSamples(unittest.TestCase):
    def setUp(self):
        self.push = make_run("push")
        self.other = make_run("other", depth=0.005, seed=1)

    def assert_named(self, campaign, *names):
        found = check_recording(campaign)
        told = [f.sentence() for f in found]
        self.assertEqual(
            sorted(f.fault.name for f in found), sorted(names), told
        )
        return found

    def test_sound_runs_have_no_fault(self):
        self.assert_named(campaign_of(self.push, self.other))

    def test_a_length_that_gets_stuck_is_named_with_its_time(self):
        x = self.push.channels["leg2_length_m"].copy()
        x[600:] = x[600]
        run = changed(self.push, leg2_length_m=x)
        (found,) = self.assert_named(campaign_of(run), "stuck_channel")
        self.assertAlmostEqual(found.parameters["start_s"], 3.0, delta=0.05)

    def test_a_marker_that_rests_and_goes_on_from_there_is_not_stuck(self):
        # As behind play: it stands while the reference turns.
        y = np.round(self.push.channels["ring2_y_desired_m"], 5)
        low = y.min() + 0.001
        held = np.round(np.maximum(y, low), 4)
        run = changed(self.push, torso_y_m=held)
        found = [f.fault.name for f in check_recording(campaign_of(run))]
        self.assertNotIn("stuck_channel", found)
        # A sensor that comes back leaps to where the machine is by then.
        late = held.copy()
        late[300:500] = late[300]
        run = changed(self.push, torso_y_m=late)
        found = [f.fault.name for f in check_recording(campaign_of(run))]
        self.assertIn("stuck_channel", found)

    def test_a_zero_that_is_set_in_mid_run_is_named_and_undone(self):
        x = self.push.channels["torso_y_m"]
        moved = x + 0.003 * (np.arange(SAMPLES) >= 700)
        run = changed(self.push, torso_y_m=moved)
        (found,) = self.assert_named(campaign_of(run), "zero_step")
        self.assertAlmostEqual(found.parameters["offset"], 0.003, delta=3e-4)
        self.assertEqual(found.parameters["start_s"], 3.5)
        undone = found.fault.undo(
            run.channels, found.channels, found.parameters
        )
        np.testing.assert_allclose(undone["torso_y_m"], x, atol=3e-4)

    def test_a_machine_that_leaps_as_a_whole_has_its_zero(self):
        # As of lost samples: all positions leap.
        step = 0.003 * (np.arange(SAMPLES) >= 700)
        moved = {
            name: x + step
            for name, x in self.push.channels.items()
            if name.endswith("_m")
        }
        run = changed(self.push, **moved)
        found = check_recording(campaign_of(run))
        self.assertNotIn("zero_step", [f.fault.name for f in found])

    def test_a_slope_in_another_unit_is_no_clock(self):
        for scale, said in (
            (1.0 / RATE, "wrong_scale"),
            (-1.0, "reversed_sign"),
        ):
            a = scale * self.push.channels["ring2_ay_desired_m_s2"]
            run = changed(self.push, ring2_ay_desired_m_s2=a)
            (found,) = self.assert_named(campaign_of(run), said)
            self.assertEqual(found.channels, ("ring2_ay_desired_m_s2",))

    def test_a_run_that_ends_at_its_beginning_is_offered_beside_a_sign(self):
        turned = {n: x[::-1] for n, x in self.push.channels.items()}
        turned["time_s"] = self.push.channels["time_s"]
        found = check_recording(campaign_of(changed(self.push, **turned)))
        self.assertIn("opposite order", found[0].sentence())

    def test_a_force_that_is_cut_off_is_named_with_its_level(self):
        x = np.maximum(self.push.channels["ring2_force_y_N"], -4.0)
        run = changed(self.push, ring2_force_y_N=x)
        (found,) = self.assert_named(campaign_of(run), "clipped_channel")
        self.assertEqual(found.parameters["level"], -4.0)

    def test_a_marker_that_a_slow_camera_sees_is_named_with_its_interval(self):
        # Seen at 30 Hz by a clock of its own, written down at 200 Hz.
        seen = np.floor(np.arange(SAMPLES) * 30.0 / RATE) / 30.0 * RATE
        x = self.push.channels["torso_y_m"][seen.astype(int)]
        run = changed(self.push, torso_y_m=x)
        (found,) = self.assert_named(campaign_of(run), "held_channel")
        self.assertAlmostEqual(found.parameters["interval_s"], 1 / 30, 4)
        straight = found.fault.undo(run.channels, found.channels, {})
        self.assertLess(
            np.std(straight["torso_y_m"] - self.push.channels["torso_y_m"]),
            1.5 * 5e-5,
        )

    def test_a_coarse_reading_that_moves_evenly_is_not_held(self):
        steps = np.round(np.linspace(0.0, 200.0, SAMPLES))
        self.assertIsNone(interval_of(1e-4 * steps))
        shakes = np.random.default_rng(2).normal(0.0, 0.6, SAMPLES).round()
        self.assertIsNone(interval_of(1e-4 * shakes))

    def test_outliers_are_found_and_taken_out(self):
        x = self.push.channels["torso_y_m"].copy()
        at = np.arange(50, 1150, 100)
        x[at] += 0.004
        run = changed(self.push, torso_y_m=x)
        self.assert_named(campaign_of(run), "outliers")
        np.testing.assert_array_equal(np.flatnonzero(outliers_of(x)), at)

    def test_spikes_of_two_readings_at_once_are_outliers_of_both(self):
        at = np.arange(50, 1150, 100)
        spoilt = {}
        for name, size in (("torso_y_m", 0.004), ("ring2_force_y_N", 4.0)):
            spoilt[name] = self.push.channels[name].copy()
            spoilt[name][at] += size
        found = check_recording(campaign_of(changed(self.push, **spoilt)))
        told = {
            c for f in found if f.fault.name == "outliers" for c in f.channels
        }
        self.assertEqual(told, {*spoilt})

    def test_a_turn_within_two_samples_is_no_outlier(self):
        t = np.arange(400) / RATE
        way = 0.01 * np.abs((t % 1.0) - 0.5)
        # The corner is rounded, as by a machine that has mass.
        rounded = np.convolve(way, [0.3, 0.4, 0.3], mode="same")[5:-5]
        noise = 1e-7 * np.random.default_rng(5).standard_normal(len(rounded))
        self.assertFalse(outliers_of(rounded + noise).any())

    def test_what_another_reading_feels_is_no_outlier(self):
        kick = np.zeros(SAMPLES)
        kick[600] = 5.0
        since = np.maximum(np.arange(SAMPLES) - 600, 0)
        felt = 0.01 * (1.0 - np.exp(-since / 3.0))
        force = self.push.channels["ring2_force_y_N"] + kick
        alone = changed(self.push, ring2_force_y_N=force)
        self.assert_named(campaign_of(alone), "outliers")
        marker = self.push.channels["torso_y_m"] + felt
        both = changed(alone, torso_y_m=marker)
        found = check_recording(campaign_of(both))
        self.assertNotIn("outliers", [f.fault.name for f in found])

    def test_a_step_is_no_outlier(self):
        x = np.random.default_rng(0).standard_normal(500)
        x[250:] += 100.0
        self.assertFalse(outliers_of(x).any())

    def test_lost_samples_show_in_the_reference(self):
        keep = np.ones(SAMPLES, bool)
        keep[400:420] = False
        columns = {n: v[keep] for n, v in self.push.channels.items()}
        columns["time_s"] = np.arange(keep.sum()) / RATE
        run = replace(self.push, channels=columns)
        (found,) = self.assert_named(campaign_of(run), "lost_samples")
        self.assertAlmostEqual(found.parameters["start_s"], 2.0, delta=0.006)
        self.assertAlmostEqual(found.parameters["lost_s"], 0.1, delta=0.01)

    def test_a_block_that_is_there_twice_is_named(self):
        order = np.r_[0:500, 480 : SAMPLES - 20]
        columns = {n: v[order] for n, v in self.push.channels.items()}
        columns["time_s"] = self.push.time_s
        names = {
            f.fault.name
            for f in check_recording(
                campaign_of(replace(self.push, channels=columns))
            )
        }
        self.assertIn("repeated_samples", names)

    def test_rows_that_coarse_readings_make_alike_are_no_block(self):
        # Some ten values at rest: now and then rows are alike by chance.
        rng = np.random.default_rng(4)
        names = [n for n in self.push.channels if n.startswith("leg")]
        columns = dict(self.push.channels)
        for name in names:
            coarse = rng.normal(size=SAMPLES).round()
            columns[name] = columns[names[0]][0] + 1e-5 * coarse
        rows = np.array([columns[n] for n in names[:6]]).T
        self.assertLess(len(np.unique(rows, axis=0)), SAMPLES - 100)
        every = declared(campaign_of(self.push))
        known = {n: every[n] for n in names[:6]}
        run = replace(
            self.push, channels={n: columns[n] for n in ("time_s", *names[:6])}
        )
        self.assertEqual(find_repeated(run, known), [])
        order = np.r_[0:500, 480 : SAMPLES - 20]
        twice = {n: v[order] for n, v in run.channels.items()}
        twice["time_s"] = run.time_s
        (found,) = find_repeated(replace(run, channels=twice), known)
        self.assertAlmostEqual(found.parameters["samples"], 20.0, delta=2.0)

    def test_a_clock_that_is_off_is_named_with_the_true_rate(self):
        for rate in (190.0, 200.6):
            runs = [
                changed(r, time_s=r.time_s) for r in (self.push, self.other)
            ]
            # Sampled at another rate than the times say.
            runs = [self._sampled(r, rate) for r in runs]
            with self.subTest(rate=rate):
                (found,) = self.assert_named(campaign_of(*runs), "wrong_clock")
                true = found.parameters["true_rate_hz"]
                self.assertAlmostEqual(true, rate, delta=0.05)
                self.assertTrue(found.of_all)

    def _sampled(self, run, rate):
        ratio = RATE / rate
        v = run.channels["ring2_vy_desired_m_s"] / ratio
        a = run.channels["ring2_ay_desired_m_s2"] / ratio**2
        return changed(run, ring2_vy_desired_m_s=v, ring2_ay_desired_m_s2=a)

    def test_a_scaled_reference_velocity_is_named(self):
        v = 1e1 * self.push.channels["ring2_vy_desired_m_s"]
        run = changed(self.push, ring2_vy_desired_m_s=v)
        (found,) = self.assert_named(campaign_of(run), "wrong_scale")
        self.assertEqual(found.channels, ("ring2_vy_desired_m_s",))
        self.assertAlmostEqual(found.parameters["scale"], 10.0, delta=0.1)


class TestManifest(unittest.TestCase):
    def setUp(self):
        self.push = make_run("push")
        self.again = make_run("again", seed=5, repeat_of="push.csv")
        self.other = make_run("other", depth=0.005, seed=1)

    def test_a_repeat_has_the_same_inputs(self):
        campaign = campaign_of(self.push, self.again, self.other)
        self.assertEqual(check_recording(campaign), [])

    def test_a_false_repeat_sets_no_noise_floor(self):
        run = replace(self.other, repeat_of="push.csv")
        campaign = campaign_of(self.push, run)
        (found,) = check_recording(campaign)
        self.assertEqual(found.fault.name, "false_repeat")
        self.assertEqual(found.severity, "error")
        cleaned = without_false_repeats(campaign, [found])
        self.assertFalse(any(r.repeat_of for r in cleaned.runs))

    def test_exchanged_files_are_named_by_the_repeat(self):
        push = replace(self.push, channels=self.other.channels)
        other = replace(self.other, channels=self.push.channels)
        found = check_recording(campaign_of(push, self.again, other))
        names = {f.fault.name: f.runs for f in found}
        self.assertEqual(names["exchanged_runs"], ("push.csv", "other.csv"))

    def test_a_copied_validation_run_validates_nothing(self):
        copy = replace(self.push, file="check.csv", split="validation")
        (found,) = check_recording(campaign_of(self.push, copy))
        self.assertEqual(found.fault.name, "copied_run")
        self.assertEqual(found.runs, ("check.csv",))
        self.assertIn("does not count as validation", found.detail)

    def test_a_copy_that_was_altered_is_told_by_its_noise(self):
        other = np.random.default_rng(7)

        def average(a, b):
            return 0.5 * (a + b)

        ways = {
            "scaled": lambda x, y: 1.0001 * x,
            "half a sample late": lambda x, y: average(x, np.roll(x, 1)),
            "with a tenth more noise": lambda x, y: x + 0.1 * shake(x),
            "with as much noise again": lambda x, y: x + shake(x),
            "the mean of two runs": average,
            "of fewer digits": lambda x, y: np.round(x, 4),
            "upside down": lambda x, y: -x,
        }

        def shake(x):
            size = robust_deviation(local_error(x)) / np.sqrt(70.0 / 36.0)
            return size * other.standard_normal(len(x))

        for title, alter in ways.items():
            columns = {
                name: x
                if name == "time_s" or "ring2_y" in name or "desired" in name
                else alter(x, self.again.channels[name])
                for name, x in self.push.channels.items()
            }
            copy = replace(
                self.push, file="copy.csv", split="validation", channels=columns
            )
            with self.subTest(way=title):
                runs = self.push, self.other, copy
                campaign = campaign_of(*runs)
                found = find_copies(runs, campaign.known_channels)
                told = [f.detail for f in found]
                self.assertEqual([f.runs for f in found], [("copy.csv",)], told)
                self.assertIn("noise is that of push.csv", told[0])

    def test_a_hum_and_a_jolt_that_runs_share_are_no_copy(self):
        t = self.push.time_s
        hum = 0.2 * np.sin(2.0 * np.pi * 47.0 * t)
        jolt = 5.0 * (abs(t - 3.0) < 0.01)
        for shared in (hum, jolt):
            runs = [
                changed(
                    run,
                    **{
                        name: x + shared
                        for name, x in run.channels.items()
                        if "force_x" in name or "torso_x" in name
                    },
                )
                for run in (self.push, self.other)
            ]
            known = campaign_of(*runs).known_channels
            self.assertEqual(find_copies(runs, known), [])


if __name__ == "__main__":
    unittest.main()

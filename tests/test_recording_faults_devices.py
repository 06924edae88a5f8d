"""Faults put into recordings of one drive, and of a pad on tissue."""

import unittest
from functools import partial

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.recording import LoadCampaign
from brace_drake.recording_faults import check_recording
from tests import axis_recordings, pad_recordings, test_leg_bench
from tests.shared_data import SHARED
from tests.test_recording_faults import spoil

COMMAND, POSITION = "force_command_N", "position_m"
DESIRED = "position_desired_m"
_EMPS = SHARED / "real" / "emps"


def changed(name, law):
    """A spoiler that puts a law over one channel."""
    return lambda columns: {**columns, name: law(columns[name])}


def late(samples: int):
    return lambda v: np.concatenate([np.full(samples, v[0]), v[:-samples]])


def rounded(**steps: float):
    """A spoiler that rounds channels to steps."""

    def change(columns):
        new = {n: np.round(columns[n] / q) * q for n, q in steps.items() if q}
        return {**columns, **new}

    return change


def at_rest(columns, rows: int):
    """A run that rests where it begins before it moves."""
    held = {n: np.r_[np.full(rows, x[0]), x] for n, x in columns.items()}
    period = columns["time_s"][1] - columns["time_s"][0]
    return {**held, "time_s": np.arange(len(held["time_s"])) * period}


def swapped(a: str, b: str):
    return lambda c: {**c, a: c[b], b: c[a]}


# What is done to a drive's columns, and the fault and channels that it is.
FAULTS = (
    (changed(POSITION, np.negative), "reversed_sign", [POSITION]),
    (changed(COMMAND, np.negative), "reversed_sign", [COMMAND]),
    (changed(POSITION, lambda v: 1.1 * v), "wrong_scale", [POSITION]),
    (changed(DESIRED, lambda v: 1.05 * v), "wrong_scale", [DESIRED]),
    (changed(COMMAND, lambda v: v / 4.448), "wrong_scale", [COMMAND]),
    (changed(COMMAND, late(20)), "skewed_channel", [COMMAND]),
    (swapped(POSITION, DESIRED), "exchanged_channels", [POSITION, DESIRED]),
)
# What a controller of other gains, or of another velocity, does as well.
NUMBERS = (
    changed(COMMAND, lambda v: 1.1 * v),
    changed(COMMAND, late(2)),
)


class DriveCases:
    """Faults of a drive's recorder, on any sound campaign of one."""

    def found(self, change=dict):
        campaign = spoil(self.sound, change)
        return check_recording(campaign, MakeDevice(campaign))

    def test_a_sound_recording_has_no_fault(self):
        self.assertEqual(self.found(), [])

    def test_each_fault_is_named_with_its_channels(self):
        for change, name, channels in FAULTS:
            with self.subTest(name=name, channels=channels):
                found = self.found(change)
                told = [f.sentence() for f in found]
                self.assertEqual([f.fault.name for f in found], [name], told)
                self.assertEqual(set(found[0].channels), set(channels), told)
                self.assertTrue(found[0].is_certain)

    def test_a_controller_of_other_numbers_leaves_the_verdict_alone(self):
        for change in NUMBERS:
            found = self.found(change)
            self.assertEqual([f.fault.name for f in found], ["contradiction"])
            self.assertFalse(found[0].is_certain)


class TestDrive(DriveCases, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sound = test_leg_bench.make_campaign()


@unittest.skipUnless(_EMPS.is_dir(), f"no recordings of EMPS in {_EMPS}")
class TestRealDrive(DriveCases, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sound = LoadCampaign(_EMPS)

    def test_forces_that_are_not_told_are_no_fault_that_has_a_name(self):
        found = self.found(
            lambda c: {n: v for n, v in c.items() if n != "external_force_N"}
        )
        self.assertEqual([f.fault.name for f in found], ["contradiction"])
        self.assertEqual(found[0].runs, ("tracking_with_pulses.csv",))
        self.assertFalse(found[0].is_certain)


class TestPad(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        def force(motion, time):
            return pad_recordings.standard_linear_solid(
                motion, time, 900.0, 20.0, 1e-3
            )

        cls.sound = pad_recordings.make_campaign(force)

    def found(self, change=dict, only=lambda run: True):
        campaign = spoil(self.sound, change, only)
        return check_recording(campaign, MakeDevice(campaign))

    def test_a_sound_recording_has_no_fault(self):
        self.assertEqual(self.found(), [])

    def test_a_pad_that_pulls_alone_has_its_sign_turned(self):
        for name in ("force_N", "displacement_m"):
            with self.subTest(name=name):
                (found,) = self.found(changed(name, np.negative))
                self.assertEqual(found.fault.name, "reversed_sign")
                self.assertEqual(found.channels, (name,))
                self.assertTrue(found.of_all)

    def test_one_run_of_the_other_sign_is_named(self):
        (found,) = self.found(
            changed("force_N", np.negative),
            lambda run: run.file == "stairs.csv",
        )
        self.assertEqual(found.runs, ("stairs.csv",))

    def test_coarse_readings_are_no_fault(self):
        for way, force in ((1e-5, 0.05), (1e-4, 0.1), (1e-5, 0.2), (0.0, 1.0)):
            with self.subTest(way=way, force=force):
                found = self.found(rounded(displacement_m=way, force_N=force))
                self.assertEqual(found, [])

    def test_a_block_of_rows_that_is_there_twice_is_named(self):
        for at in (300, 700):
            order = np.r_[np.arange(at), np.arange(at - 50, 1251)]
            with self.subTest(at=at):
                (found,) = self.found(
                    lambda c, o=order: {
                        n: x if n == "time_s" else x[o[: len(x)]]
                        for n, x in c.items()
                    },
                    lambda run: run.file == "stairs.csv",
                )
                self.assertEqual(found.fault.name, "repeated_samples")
                self.assertEqual(found.row, at + 1)

    def test_holds_and_corners_of_an_exact_motion_are_no_fault(self):
        for rate in (20.0, 1000.0):
            with self.subTest(rate=rate):
                exact = pad_recordings.make_campaign(
                    pad_recordings.relaxing, rate=rate, displacement_noise=0.0
                )
                self.assertEqual(check_recording(exact, MakeDevice(exact)), [])

    def test_a_repeat_that_is_answered_otherwise_is_told(self):
        (found,) = self.found(
            changed("force_N", lambda v: 2.0 * v),
            lambda run: run.file == "again.csv",
        )
        self.assertEqual(found.fault.name, "false_repeat")
        self.assertFalse(found.is_certain)
        self.assertAlmostEqual(found.parameters["difference"], 0.6, delta=0.3)

    def test_a_motion_that_comes_round_again_is_no_block_twice(self):
        # Commanded exactly, and a force without any noise.
        def force(motion, time):
            return pad_recordings.standard_linear_solid(
                motion, time, 900.0, 0.0, 1e-3
            )

        exact = pad_recordings.make_campaign(
            force, force_noise=0.0, displacement_noise=0.0
        )
        found = check_recording(exact, MakeDevice(exact))
        names = {f.fault.name for f in found}
        self.assertNotIn("repeated_samples", names)

    def test_a_zero_that_is_off_is_a_warning(self):
        (found,) = self.found(changed("force_N", lambda v: v - 5.0))
        self.assertEqual(found.fault.name, "contradiction")
        self.assertFalse(found.is_certain)


class TestAxis(unittest.TestCase):
    def test_an_encoder_that_stands_at_its_ends_is_not_cut_off(self):
        def trapezoid(columns):
            t = columns["time_s"]
            y = np.interp(t % 8.0, [0, 1, 3, 5, 7, 8], [0, 5, 5, -5, -5, 0])
            return {**columns, "position_m": np.round(0.01 * y, 4)}

        sound = axis_recordings.make_campaign(lambda p, b: 1e3 * p[:, 0])
        found = self.found(spoil(sound, trapezoid))
        names = {f.fault.name for f in found}
        self.assertNotIn("clipped_channel", names)

    def found(self, campaign):
        return check_recording(campaign, MakeDevice(campaign))

    def test_coarse_readings_are_no_fault_at_rest_either(self):
        sound = axis_recordings.make_campaign(
            lambda p, b: 2.0 * p[:, 2] + 30.0 * p[:, 1] + 100.0 * p[:, 0]
        )
        for step in (1e-5, 1e-4, 1e-3):
            for rest in (0, 200):
                with self.subTest(step=step, rest=rest):
                    coarse = spoil(sound, rounded(position_m=step, force_N=0.1))
                    campaign = spoil(coarse, partial(at_rest, rows=rest))
                    self.assertEqual(self.found(campaign), [])


if __name__ == "__main__":
    unittest.main()

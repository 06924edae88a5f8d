"""Faults in closed-form recordings of machines without a known controller."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.diagnosis import diagnose
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.recording_faults.against_twin import Maker, judge_campaign
from brace_drake.recording_faults.library.time.lost_samples import jumps_of
from tests import axis_recordings, pad_recordings


def plain(path, beside):
    """Force on mass, damper and spring, N."""
    return 2.0 * path[:, 2] + 30.0 * path[:, 1] + 100.0 * path[:, 0]


def other(path, beside):
    """Of another machine."""
    return 5.0 * path[:, 2] + 70.0 * path[:, 1] + 10.0 * path[:, 0]


def softer(motion, time):
    """Force on other tissue, N."""
    return pad_recordings.standard_linear_solid(
        motion, time, 2600.0, 25.0, 2e-4
    )


def of_file(file, change):
    """A campaign with one file's channels changed."""
    return lambda c: replace(
        c,
        runs=tuple(
            replace(r, channels=change(r.channels)) if r.file == file else r
            for r in c.runs
        ),
    )


def of_all(change):
    return lambda c: replace(
        c, runs=tuple(replace(r, channels=change(r.channels)) for r in c.runs)
    )


def times(name, factor):
    return lambda columns: {**columns, name: columns[name] * factor}


def late(name, rows):
    return lambda columns: {
        **columns,
        name: np.concatenate(
            [np.full(rows, columns[name][0]), columns[name][:-rows]]
        ),
    }


def slow(name, rate):
    """Of a channel by a clock of its own."""
    return lambda columns: {
        **columns,
        name: np.interp(
            (1.0 - rate) * columns["time_s"], columns["time_s"], columns[name]
        ),
    }


def tared(name, seconds, offset):
    """Of a channel whose zero is set anew."""
    return lambda columns: {
        **columns,
        name: columns[name] + offset * (columns["time_s"] >= seconds),
    }


def without(begin, end):
    """Rows that are not there, under times that go on evenly."""

    def cut(columns):
        kept = {n: np.delete(x, slice(begin, end)) for n, x in columns.items()}
        return {**kept, "time_s": columns["time_s"][: len(kept["time_s"])]}

    return cut


def backwards(columns):
    turned = {n: x[::-1].copy() for n, x in columns.items()}
    return {**turned, "time_s": columns["time_s"]}


def of_other(file, donor):
    """One run of another machine."""
    (run,) = [r for r in donor.runs if r.file == file]
    return of_file(file, lambda columns: run.channels)


FORCE = "force_N"
# What is done, and the fault, files and channels that it is.
ON_AXIS = (
    (
        of_file("fast.csv", times(FORCE, 1.0 / 9.80665)),
        ("wrong_scale", ("fast.csv",), (FORCE,)),
    ),
    (
        of_file("long.csv", times("position_m", 1e3)),
        ("wrong_scale", ("long.csv",), ("position_m",)),
    ),
    (
        of_all(without(700, 760)),
        ("lost_samples", ("short.csv", "long.csv", "fast.csv"), ()),
    ),
    (
        of_file("new.csv", times(FORCE, 2.0)),
        ("wrong_scale", ("new.csv",), (FORCE,)),
    ),
    (
        of_file("new.csv", late(FORCE, 15)),
        ("skewed_channel", ("new.csv",), (FORCE,)),
    ),
    (
        of_all(slow(FORCE, -0.01)),
        ("own_clock", ("short.csv", "long.csv", "fast.csv"), (FORCE,)),
    ),
    (
        of_file("fast.csv", tared(FORCE, 6.0, -1.0)),
        ("zero_step", ("fast.csv",), (FORCE,)),
    ),
    (
        of_other("new.csv", axis_recordings.make_campaign(other)),
        ("other_subject", ("new.csv",), ()),
    ),
    (
        of_other("fast.csv", axis_recordings.make_campaign(other)),
        ("other_subject", ("fast.csv",), ()),
    ),
)
ON_PAD = (
    (
        of_file("cycles.csv", times(FORCE, 2.0)),
        ("wrong_scale", ("cycles.csv",), (FORCE,)),
    ),
    (
        of_file("slow.csv", backwards),
        ("reversed_run", ("slow.csv",), ()),
    ),
    (
        of_all(late(FORCE, 12)),
        (
            "skewed_channel",
            ("stairs.csv", "slow.csv", "cycles.csv", "again.csv"),
            (FORCE,),
        ),
    ),
    (
        of_other("fresh.csv", pad_recordings.make_campaign(softer)),
        ("other_subject", ("fresh.csv",), ()),
    ),
)
# Machines with an effect, and no fault.
EFFECTS = {
    "a stop that one run reaches": lambda p, b: (
        plain(p, b) + 5e3 * np.maximum(p[:, 0] - 0.035, 0.0)
    ),
    "cogging": lambda p, b: plain(p, b) + 0.3 * np.sin(600.0 * p[:, 0]),
}


def judged(campaign):
    """Faults that a diagnosis finds."""
    return list(diagnose(campaign, jobs=1).recording)


def judged_alone(campaign):
    """Faults of a machine that is known to have no effect."""
    maker = Maker(
        MakeDevice,
        lambda device, runs: fit_nominal(Evaluator(device.twin, runs, 1)),
    )
    found, _ = judge_campaign(campaign, MakeDevice(campaign), maker=maker)
    return found


class TestUndone(unittest.TestCase):
    def check(self, sound, cases):
        for change, expected in cases:
            with self.subTest(expected):
                (found,) = judged_alone(change(sound))
                told = found.fault.name, found.runs, found.channels
                self.assertEqual(told, expected)
                self.assertTrue(found.is_certain)
                self.assertLess(found.after, 1.5)

    def test_faults_of_an_axis_are_named_with_their_runs_and_channels(self):
        self.check(axis_recordings.make_campaign(plain), ON_AXIS)

    def test_faults_of_a_pad_are_named_with_their_runs_and_channels(self):
        sound = pad_recordings.make_campaign(pad_recordings.linear)
        self.check(sound, ON_PAD)

    def test_a_fault_beside_an_effect_is_named(self):
        stiffens = axis_recordings.make_campaign(
            lambda p, b: plain(p, b) + 2e5 * p[:, 0] ** 3
        )
        change = of_file("short.csv", times(FORCE, 0.5))
        (found,) = judged(change(stiffens))
        self.assertEqual(found.fault.name, "wrong_scale")
        self.assertEqual(found.runs, ("short.csv",))
        self.assertAlmostEqual(found.parameters["scale"], 0.5, delta=0.01)

    def test_what_a_machine_does_is_no_fault_of_its_recording(self):
        for name, law in EFFECTS.items():
            with self.subTest(name):
                found = judged(axis_recordings.make_campaign(law))
                # What one run alone shows may be either.
                if found:
                    self.assertEqual(name, "a stop that one run reaches")
                    self.assertEqual(found[0].fault.name, "contradiction")
                    self.assertFalse(found[0].is_certain)
        pad = pad_recordings.make_campaign(pad_recordings.relaxing)
        self.assertEqual(judged(pad), [])

    def test_the_size_of_a_fault_is_told(self):
        change, _ = ON_AXIS[0]
        sound = axis_recordings.make_campaign(plain)
        (found,) = judged_alone(change(sound))
        self.assertIn("in fast.csv", found.sentence())
        self.assertIn("as in kgf", found.sentence())

    def test_an_encoder_that_settles_by_single_steps_has_lost_nothing(self):
        # Most of the record rests: its noise is 0, its steps are not.
        t = np.arange(3000) / 500.0
        way = np.exp(-np.clip(t - 2.0, 0.0, None) / 0.02)
        read = 7.67e-4 * np.round(2.0 * way / 7.67e-4)
        np.testing.assert_array_equal(jumps_of(read), [])
        lost = np.delete(np.sin(5.0 * t), np.arange(300, 340))
        read = 7.67e-4 * np.round(lost / 7.67e-4)
        np.testing.assert_array_equal(jumps_of(read), [299])

    def test_a_way_jumps_where_rows_are_lost_not_where_it_turns(self):
        t = np.arange(1000) / 100.0
        corners = np.abs((t % 4.0) - 2.0)
        np.testing.assert_array_equal(jumps_of(corners), [])
        step = np.where(t < 5.0, 0.0, 1.0)
        np.testing.assert_array_equal(jumps_of(step), [])
        lost = np.delete(np.sin(t), slice(300, 330))
        np.testing.assert_array_equal(jumps_of(lost), [299])


if __name__ == "__main__":
    unittest.main()

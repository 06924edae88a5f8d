"""A recorded campaign that somebody has spoilt, and what a check says of it."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.device import MakeDevice
from brace_drake.recording import LoadCampaign
from brace_drake.recording_faults import check_recording
from brace_drake.recording_faults.finding import recording_verdict
from brace_drake.scenario.brace import BenchScenario
from tests.commands import run_command
from tests.shared_data import EXAMPLE
from tests.synthetic_bench import record
from tests.test_recording_faults import FORCE, spoil

FREE = "free_multisine.csv"
_REPEAT = "false_repeat"


def is_validation(run):
    return run.split == "validation"


def is_reading(name):
    return name != "time_s" and "desired" not in name


def sampled_at(ratio):
    """A spoiler: sampled so many times as seldom as the times say."""

    def change(columns):
        t = columns["time_s"]
        taken = np.arange(t[0], t[-1], ratio * (t[1] - t[0]))
        for name in columns:
            if name != "time_s":
                columns[name] = np.interp(taken, t, columns[name])
        columns["time_s"] = t[: len(taken)]

    return change


class ExampleCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sound = LoadCampaign(EXAMPLE)
        cls.device = MakeDevice(cls.sound)

    def names(self, campaign, device=None):
        """Faults by name, none of which leaves a verdict on the machine."""
        found = check_recording(campaign, device or self.device)
        verdict = recording_verdict(found)
        self.assertTrue(found)
        self.assertFalse(verdict["outside_library"])
        self.assertIn("The recording, not the machine", verdict["sentence"])
        self.assertTrue(any(f.is_certain for f in found))
        return {f.fault.name: f for f in found}


class TestChannels(ExampleCase):
    def test_the_example_has_no_fault(self):
        self.assertEqual(check_recording(self.sound, self.device), [])

    def test_forces_doubled_in_the_validation_run_are_named_there(self):
        def change(columns):
            for axis in "xyz":
                columns[f"ring2_force_{axis}_N"] *= 2.0

        found = self.names(spoil(self.sound, change, is_validation))
        self.assertEqual(set(found), {"wrong_scale"})
        fault = found["wrong_scale"]
        self.assertEqual(fault.runs, ("validation_push.csv",))
        self.assertAlmostEqual(fault.parameters["scale"], 2.0, delta=0.02)

    def test_exchanged_commands_are_named(self):
        a, b = "leg2_force_command_N", "leg3_force_command_N"

        def change(columns):
            columns[a], columns[b] = columns[b], columns[a]

        found = self.names(spoil(self.sound, change))
        self.assertEqual(set(found), {"exchanged_channels"})
        self.assertEqual(set(found["exchanged_channels"].channels), {a, b})

    def test_a_force_that_gets_stuck_is_named(self):
        def change(columns):
            columns[FORCE][600:] = columns[FORCE][600]

        def is_first(run):
            return run.file == "push.csv"

        found = self.names(spoil(self.sound, change, is_first))
        self.assertEqual(set(found), {"stuck_channel"})
        self.assertEqual(found["stuck_channel"].channels, (FORCE,))
        self.assertEqual(found["stuck_channel"].runs, ("push.csv",))

    def test_outliers_in_one_of_a_hundred_readings_are_named(self):
        noise = np.random.default_rng(0)

        def change(columns):
            for name in filter(is_reading, columns):
                x = columns[name]
                at = noise.choice(len(x), len(x) // 100, replace=False)
                x[at] += 5.0 * np.std(x) * noise.choice([-1.0, 1.0], len(at))

        found = self.names(spoil(self.sound, change))
        # Of repeats the outliers are not alike, which may be told as well.
        self.assertTrue({"outliers"} <= set(found) <= {"outliers", _REPEAT})
        self.assertTrue(found["outliers"].is_certain)

    def test_channels_that_are_all_constant_are_named(self):
        def hold(columns):
            for name in filter(is_reading, columns):
                columns[name][:] = columns[name][0]

        def hold_all(columns):
            hold(columns)
            for name in columns:
                if name != "time_s":
                    columns[name][:] = columns[name][0]

        for change in (hold, hold_all):
            found = self.names(spoil(self.sound, change))
            with self.subTest(change.__name__):
                self.assertEqual(set(found), {"stuck_channel"})


class TestTimes(ExampleCase):
    def test_a_clock_that_is_off_is_named_with_its_ratio(self):
        for ratio in (200.0 / 190.0, 1.003, 0.997):
            with self.subTest(ratio):
                found = self.names(spoil(self.sound, sampled_at(ratio)))
                self.assertEqual(set(found), {"wrong_clock"})
                fault = found["wrong_clock"]
                self.assertTrue(fault.of_all)
                rate = fault.parameters["true_rate_hz"]
                self.assertAlmostEqual(rate, 200.0 / ratio, delta=0.05)

    def test_blocks_of_lost_samples_are_named(self):
        def change(columns):
            gone = [range(begin, begin + 20) for begin in (400, 900, 1500)]
            time = columns.pop("time_s")
            for name in columns:
                columns[name] = np.delete(columns[name], np.ravel(gone))
                kept = len(columns[name])
            columns["time_s"] = time[:kept]

        found = self.names(spoil(self.sound, change))
        self.assertEqual(set(found), {"lost_samples"})


class TestRuns(ExampleCase):
    def test_exchanged_files_of_a_push_and_a_free_run_are_told(self):
        runs = {r.file: r for r in self.sound.runs}
        other = {"push.csv": FREE, FREE: "push.csv"}
        exchanged = tuple(
            replace(r, channels=runs[other.get(r.file, r.file)].channels)
            for r in self.sound.runs
        )
        found = self.names(replace(self.sound, runs=exchanged))
        # No repeat, and so no noise floor.
        self.assertEqual(found[_REPEAT].runs, ("push_repeat.csv",))
        self.assertEqual(set(found["wrong_contact"].runs), set(other))

    def test_a_free_run_that_was_imported_as_contact_is_refused(self):
        # `contact: true` is what a map means that says nothing.
        names = list(self.sound.runs[0].channels)
        runs = [{"file": str(EXAMPLE / r.file)} for r in self.sound.runs]
        runs[-1]["split"] = "validation"
        rules = {
            "format": "brace-import/1",
            "device": "bench stage 2",
            "columns": dict(zip(names, names, strict=True)),
            "runs": runs,
        }
        with tempfile.TemporaryDirectory() as folder:
            path, out = Path(folder, "map.yaml"), Path(folder, "out")
            path.write_text(yaml.safe_dump(rules))
            status, _, errors = run_command("import", path, "--out", out)
            self.assertEqual(status, 0, errors)
            status, said, _ = run_command("check", out)
        self.assertEqual(status, 2, said)
        self.assertIn(f"{FREE}: wrong contact in the manifest", said)
        self.assertIn("1 error", said)


class TestGeometry(ExampleCase):
    def recorded(self, scenario):
        twin = BenchTwin(scenario, 1e-3 / 3.0)
        subject = np.array([p.nominal for p in twin.subject])
        return record(twin, subject, (), 0)

    def test_another_geometry_is_named_with_the_lengths_at_rest(self):
        other = BenchScenario()
        other.joints.stage2.lower.radius = 0.24
        campaign = self.recorded(other)
        found = self.names(campaign)
        self.assertEqual(set(found), {"other_geometry"})
        fault = found["other_geometry"]
        self.assertIn("lengths at rest differ by up to 21.7 mm", fault.detail)
        own = MakeDevice(campaign, other)
        self.assertEqual(check_recording(campaign, own), [])

    def test_a_ring_that_is_higher_is_told_to_name_its_scenario(self):
        # Legs that are all longer by one factor may have another unit.
        other = BenchScenario()
        other.ring_heights = [0.0, 0.145, 0.259, 0.32]
        (found,) = self.names(self.recorded(other)).values()
        self.assertIn("name its own scenario", found.fault.remedy)


if __name__ == "__main__":
    unittest.main()

"""Reading and writing of campaign folders."""

import os
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import yaml

from brace_drake.core.errors import CampaignError, OutputError
from brace_drake.core.reading import files
from brace_drake.recording import Campaign, LoadCampaign, Run, WriteCampaign

ROWS = 400
RATE_HZ = 200.0


def make_run(
    file: str = "push.csv", seed: int = 0, contact: bool = True, **fields
) -> Run:
    """Two seconds of a ring that moves a spring and damper, with noise."""
    noise = np.random.default_rng(seed)
    time = np.arange(ROWS) / RATE_HZ
    omega = 2.0 * np.pi * 0.5
    y_d = -0.005 * (1.0 - np.cos(omega * time))
    vy_d = -0.005 * omega * np.sin(omega * time)
    channels = {"time_s": time}
    for k in range(1, 7):
        command = 2.18 + 0.3 * k * np.sin(omega * time)
        channels[f"leg{k}_force_command_N"] = command
        channels[f"leg{k}_length_m"] = 0.141 + 0.1 * k * y_d
    for i, axis in enumerate("xyz"):
        force = 0.03 * noise.standard_normal(ROWS)
        torso = 5e-5 * noise.standard_normal(ROWS)
        if axis == "y" and contact:
            force += 0.7 * (1800.0 * y_d + 220.0 * vy_d)
            torso += 0.7 * y_d
        channels[f"ring2_force_{axis}_N"] = force + 0.01 * i
        channels[f"torso_{axis}_m"] = torso
    channels |= {
        "ring2_y_desired_m": y_d,
        "ring2_vy_desired_m_s": vy_d,
        "ring2_ay_desired_m_s2": -0.005 * omega**2 * np.cos(omega * time),
        "ring2_y_virtual_m": 0.9 * y_d,
    }
    settings = {"motion": "push", "repeat_of": None, "split": "fit"} | fields
    return Run(file=file, contact=contact, channels=channels, **settings)


def make_campaign() -> Campaign:
    """A sound campaign of the bench: push, repeat, free, validation."""
    runs = (
        make_run("push.csv", 1),
        make_run("push_repeat.csv", 2, repeat_of="push.csv"),
        make_run("free.csv", 3, contact=False),
        make_run("validation.csv", 4, split="validation"),
    )
    return Campaign(Path(), "bench stage 2", RATE_HZ, "made up", runs)


def make_leg_bench() -> Campaign:
    """A mass with friction under position control."""
    time = np.arange(ROWS) / RATE_HZ
    position = 0.1 * (1.0 - np.cos(2.0 * np.pi * time))
    velocity = np.gradient(position) * RATE_HZ
    force = 50.0 * np.gradient(velocity) * RATE_HZ + 200.0 * velocity
    channels = {
        "time_s": time,
        "force_command_N": force,
        "position_m": position,
        "position_desired_m": position + 0.001,
    }
    runs = tuple(
        Run(f"{split}.csv", False, "tracking", None, split, channels)
        for split in ("fit", "validation")
    )
    return Campaign(
        Path(),
        "leg bench",
        RATE_HZ,
        "made up",
        runs,
        nominal={"mass_kg": 50.0, "viscous_N_s_m": 200.0},
        control={"kp_1_s": 160.0, "kv_N_s_m": 8000.0, "force_limit_N": 900.0},
    )


def make_pad_bench() -> Campaign:
    """A pad pressed into a spring and damper."""
    time = np.arange(ROWS) / RATE_HZ
    depth = 0.005 * (1.0 - np.cos(2.0 * np.pi * time))
    force = 6400.0 * depth + 150.0 * np.gradient(depth) * RATE_HZ
    channels = {"time_s": time, "displacement_m": depth, "force_N": force}
    runs = tuple(
        Run(f"{split}.csv", True, "press", None, split, channels)
        for split in ("fit", "validation")
    )
    return Campaign(Path(), "pad bench", RATE_HZ, "made up", runs)


class CampaignFolderTest(unittest.TestCase):
    """A test with an empty temporary folder."""

    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.path = self.folder / "campaign"

    def describe(self, **changes):
        """Changes keys of campaign.yaml; None takes a key away."""
        file = self.path / "campaign.yaml"
        content = yaml.safe_load(file.read_text()) | changes
        content = {k: v for k, v in content.items() if v is not None}
        file.write_text(yaml.safe_dump(content, sort_keys=False))

    def lines(self, file="push.csv"):
        return (self.path / file).read_text().splitlines()

    def put_lines(self, lines, file="push.csv", end="\n"):
        (self.path / file).write_text("\n".join(lines) + end)


class TestReadAndWrite(CampaignFolderTest):
    def test_what_is_written_reads_back_to_the_written_precision(self):
        for campaign in (make_campaign(), make_leg_bench(), make_pad_bench()):
            with self.subTest(campaign.device):
                path = self.folder / campaign.device
                WriteCampaign(campaign, path)
                again = LoadCampaign(path)
                self.assertEqual(again.warnings, ())
                for key in ("device", "rate_hz", "subject"):
                    self.assertEqual(
                        getattr(again, key), getattr(campaign, key)
                    )
                self.assertEqual(again.nominal, campaign.nominal)
                self.assertEqual(again.control, campaign.control)
                for run, other in zip(campaign.runs, again.runs, strict=True):
                    self.assert_same_run(run, other)

    def assert_same_run(self, run, other):
        self.assertEqual(list(run.channels), list(other.channels))
        self.assertEqual(replace(run, channels={}), replace(other, channels={}))
        for name, values in run.channels.items():
            # Half a unit of the last written decimal.
            tolerance = 5.1e-6 if name.endswith("_N") else 5.1e-7
            np.testing.assert_allclose(
                other.channels[name], values, rtol=0, atol=tolerance
            )

    def test_writing_what_was_read_changes_nothing(self):
        WriteCampaign(make_campaign(), self.path)
        WriteCampaign(LoadCampaign(self.path), self.folder / "again")
        for file in self.path.iterdir():
            other = self.folder / "again" / file.name
            self.assertEqual(file.read_bytes(), other.read_bytes())

    def test_a_campaign_knows_its_name_and_its_splits(self):
        WriteCampaign(make_campaign(), self.path)
        campaign = LoadCampaign(str(self.path))
        self.assertEqual(campaign.name, "campaign")
        self.assertEqual(len(campaign.split("fit")), 3)
        self.assertEqual(campaign.split("validation")[0].name, "validation")

    def test_unknown_columns_are_kept_and_ignored(self):
        WriteCampaign(make_campaign(), self.path)
        header, *rows = self.lines()
        rows = [f"{row},nan,ok {i}" for i, row in enumerate(rows)]
        self.put_lines([f"{header},humidity,remark", *rows])
        run = LoadCampaign(self.path).runs[0]
        self.assertTrue(np.isnan(run.channels["humidity"]).all())
        self.assertEqual(run.channels["remark"][3], "ok 3")
        WriteCampaign(LoadCampaign(self.path), self.folder / "again")
        again = LoadCampaign(self.folder / "again").runs[0]
        self.assertEqual(again.channels["remark"][3], "ok 3")

    def test_windows_line_ends_and_a_missing_last_one_are_read(self):
        WriteCampaign(make_campaign(), self.path)
        text = (self.path / "push.csv").read_text()
        data = b"\xef\xbb\xbf" + text.strip().replace("\n", "\r\n").encode()
        (self.path / "push.csv").write_bytes(data)
        run = LoadCampaign(self.path).runs[0]
        self.assertEqual(run.time_s.shape, (ROWS,))

    def test_an_error_is_one_line_that_counts_the_others(self):
        WriteCampaign(make_campaign(), self.path)
        self.describe(rate_hz=-1, device="toaster", format="x")
        with self.assertRaises(CampaignError) as caught:
            LoadCampaign(self.path)
        message = str(caught.exception)
        self.assertNotIn("\n", message)
        self.assertIn("format", message)
        self.assertIn("and 2 more; run `brace-drake check ", message)

    def test_a_single_error_is_told_without_a_count(self):
        with self.assertRaises(CampaignError) as caught:
            LoadCampaign(self.path)
        self.assertEqual(str(caught.exception), f"{self.path}: no such folder")

    def test_warnings_come_with_the_campaign(self):
        campaign = make_campaign()
        channels = dict(campaign.runs[0].channels)
        channels["leg3_length_m"] = np.full(ROWS, 0.141)
        runs = (replace(campaign.runs[0], channels=channels),)
        WriteCampaign(replace(campaign, runs=runs), self.path)
        warnings = LoadCampaign(self.path).warnings
        self.assertEqual([w.column for w in warnings], [None, "leg3_length_m"])

    def test_each_file_is_read_once(self):
        WriteCampaign(make_campaign(), self.path)
        opened = []
        read = open

        def count(path, *args, **options):
            opened.append(path.name)
            return read(path, *args, **options)

        with mock.patch.object(files, "open", count, create=True):
            LoadCampaign(self.path)
        self.assertEqual(sorted(opened), sorted(os.listdir(self.path)))


class TestWriteRefusals(CampaignFolderTest):
    def assert_refused(self, path, word, campaign=None):
        with self.assertRaises(OutputError) as caught:
            WriteCampaign(campaign or make_campaign(), path)
        self.assertIn(word, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))

    def test_a_folder_that_is_not_empty_is_not_replaced(self):
        self.path.mkdir()
        (self.path / "notes.txt").write_text("keep me")
        self.assert_refused(self.path, "not empty")
        self.assertEqual(os.listdir(self.path), ["notes.txt"])
        self.assertEqual(os.listdir(self.folder), ["campaign"])

    def test_an_empty_folder_is_filled(self):
        self.path.mkdir()
        WriteCampaign(make_campaign(), self.path)
        self.assertEqual(os.listdir(self.folder), ["campaign"])
        self.assertEqual(len(LoadCampaign(self.path).runs), 4)

    def test_a_place_that_is_no_folder_is_told_in_one_line(self):
        (self.folder / "file").write_text("")
        self.assert_refused(self.folder / "file", "is a file")
        self.assert_refused(self.folder / "file" / "out", "file is a file")

    def test_a_read_only_place_is_told_in_one_line(self):
        refusal = OSError(30, "Read-only file system")
        with mock.patch.object(Path, "mkdir", side_effect=refusal):
            self.assert_refused(self.path, "Read-only file system")

    def test_a_failure_leaves_nothing_behind(self):
        refusal = OSError(28, "No space left on device")
        with mock.patch.object(Path, "write_text", side_effect=refusal):
            self.assert_refused(self.path, "No space left")
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_run_outside_the_folder_is_refused(self):
        campaign = make_campaign()
        runs = (replace(campaign.runs[0], file="../push.csv"),)
        self.assert_refused(self.path, "leaves", replace(campaign, runs=runs))


if __name__ == "__main__":
    unittest.main()

"""Every kind of problem is found, with its file, row and column."""

import argparse
import contextlib
import io
import shutil
import time
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from brace_drake.cli.data import check
from brace_drake.recording import (
    DEVICES,
    CheckCampaign,
    Limits,
    LoadCampaign,
    WriteCampaign,
)
from brace_drake.recording.columns import near_misses
from brace_drake.recording.findings import by_message, error, warning
from brace_drake.recording.forces import explained
from brace_drake.recording.manifest import parse_manifest
from brace_drake.recording.samples import check_time, flat_extremes
from tests.test_campaign_read import (
    RATE_HZ,
    ROWS,
    CampaignFolderTest,
    make_campaign,
    make_leg_bench,
    make_pad_bench,
)

SHARED = Path(__file__).parents[2] / "shared"
EXAMPLE = Path(__file__).parent / "data" / "example"


class TestLines(unittest.TestCase):
    def test_what_is_told_of_several_files_alike_is_one_line(self):
        found = [
            *(
                warning(f"run{i}.csv", "no marker", "torso_x_m")
                for i in range(3)
            ),
            warning("run0.csv", "no marker", "torso_y_m"),
            error("run1.csv", "no marker", "torso_x_m"),
        ]
        self.assertEqual(
            by_message(found),
            [
                f"{found[0]} (and 2 other files alike)",
                str(found[3]),
                str(found[4]),
            ],
        )


class CheckTest(CampaignFolderTest):
    """A test that spoils a written campaign and looks at the problems."""

    def setUp(self):
        super().setUp()
        WriteCampaign(make_campaign(), self.path)

    def rewrite(self, campaign):
        for file in self.path.iterdir():
            file.unlink()
        WriteCampaign(campaign, self.path)

    def edit_cell(self, row, column, text, file="push.csv"):
        """Replaces one field; rows count from 1, row 0 is the header."""
        lines = self.lines(file)
        fields = lines[row].split(",")
        fields[lines[0].split(",").index(column)] = text
        lines[row] = ",".join(fields)
        self.put_lines(lines, file)

    def edit_channel(self, column, change, campaign=None, run=0):
        """Rewrites the campaign with one channel of one run changed."""
        campaign = campaign or make_campaign()
        runs = list(campaign.runs)
        channels = dict(runs[run].channels)
        channels[column] = change(channels[column])
        runs[run] = replace(runs[run], channels=channels)
        self.rewrite(replace(campaign, runs=tuple(runs)))

    def edit_run(self, number, **changes):
        file = self.path / "campaign.yaml"
        runs = yaml.safe_load(file.read_text())["runs"]
        changed = runs[number] | changes
        runs[number] = {k: v for k, v in changed.items() if v != "DROP"}
        self.describe(runs=runs)

    def assert_problem(
        self,
        *words,
        file="push.csv",
        row=None,
        column=None,
        severity="error",
        only=True,
    ):
        """Asserts that this problem, and by default no other, is found."""
        problems = CheckCampaign(self.path)
        found = [
            p
            for p in problems
            if (p.file, p.row, p.column, p.severity)
            == (str(file), row, column, severity)
            and all(word in p.message for word in words)
        ]
        listing = "\n".join(map(str, problems))
        self.assertEqual(len(found), 1, listing)
        self.assertNotIn("\n", found[0].message)
        if only:
            self.assertEqual(len(problems), 1, listing)


class TestFolder(CheckTest):
    def test_a_sound_campaign_has_no_problem(self):
        makers = (make_campaign, make_leg_bench, make_pad_bench)
        for campaign in (maker() for maker in makers):
            with self.subTest(campaign.device):
                self.rewrite(campaign)
                self.assertEqual(CheckCampaign(self.path), [])

    def test_a_missing_folder_is_an_error(self):
        self.path = self.folder / "nowhere"
        self.assert_problem("no such folder", file=self.path)

    def test_a_file_instead_of_a_folder_is_an_error(self):
        self.path = self.path / "push.csv"
        self.assert_problem("is a file", file=self.path)

    def test_an_empty_folder_is_an_error(self):
        self.path = self.folder / "empty"
        self.path.mkdir()
        self.assert_problem("empty", file=self.path)

    def test_a_folder_without_campaign_yaml_is_an_error(self):
        (self.path / "campaign.yaml").unlink()
        self.assert_problem("no campaign.yaml", file=self.path)


class TestManifest(CheckTest):
    def assert_manifest_problem(self, *words, **expected):
        self.assert_problem(*words, **{"file": "campaign.yaml"} | expected)

    def put_manifest(self, text):
        (self.path / "campaign.yaml").write_text(text)

    def test_unreadable_yaml_is_told_with_its_line(self):
        self.put_manifest("format: x\nruns: [\ndevice: }\n")
        self.assert_manifest_problem("YAML", "line 3")

    def test_yaml_that_is_no_text_is_told_with_its_line(self):
        (self.path / "campaign.yaml").write_bytes(b"a: b\nc: \xff\n")
        self.assert_manifest_problem("line 2", "UTF-8")

    def test_an_impossible_date_in_yaml_is_an_error(self):
        path = self.path / "campaign.yaml"
        lines = path.read_text().splitlines()
        lines = [s for s in lines if not s.startswith("rate_hz")]
        self.put_manifest("\n".join([*lines, "rate_hz: 2024-99-99"]))
        self.assert_manifest_problem("rate_hz", "'2024-99-99'")

    def test_yaml_that_is_no_mapping_is_an_error(self):
        for text in ("", "- a\n- b\n", "42"):
            with self.subTest(text):
                self.put_manifest(text)
                self.assert_manifest_problem("mapping")

    def test_a_wrong_format_says_what_is_allowed(self):
        self.describe(format="brace-campaign/9")
        self.assert_manifest_problem("brace-campaign/1", "brace-campaign/9")
        self.describe(format=None)
        self.assert_manifest_problem("format is missing", "brace-campaign/1")

    def test_an_unknown_device_says_which_are_known(self):
        self.describe(device="bench stage 7")
        self.assert_manifest_problem("device", *DEVICES)

    def test_a_bad_rate_is_an_error(self):
        for rate in (0, -200.0, "fast", True, float("nan"), 10**400, None):
            with self.subTest(rate):
                self.describe(rate_hz=rate)
                self.assert_manifest_problem("rate_hz", "positive")

    def test_missing_empty_or_unlisted_runs_are_an_error(self):
        for runs in (None, [], {"file": "push.csv"}, "push.csv"):
            with self.subTest(runs):
                self.describe(runs=runs)
                self.assert_manifest_problem("runs", "list")

    def test_a_run_that_is_no_mapping_is_an_error(self):
        file = self.path / "campaign.yaml"
        runs = yaml.safe_load(file.read_text())["runs"]
        self.describe(runs=["push.csv", *runs])
        self.assert_manifest_problem("run 1", "mapping")

    def test_missing_keys_of_a_run_are_listed(self):
        self.edit_run(1, motion="DROP", contact="DROP")
        self.assert_manifest_problem("run 2", "contact, motion", "push_repeat")

    def test_wrong_types_in_a_run_are_errors(self):
        cases = {
            "file": 3,
            "contact": "perhaps",
            "motion": 7,
            "repeat_of": ["push.csv"],
        }
        for key, value in cases.items():
            with self.subTest(key):
                self.rewrite(make_campaign())
                self.edit_run(2, **{key: value})
                self.assert_manifest_problem("run 3", key)

    def test_another_split_is_an_error(self):
        self.edit_run(0, split="test")
        self.assert_manifest_problem("split", "fit or validation", "'test'")

    def test_a_repeat_of_nothing_is_an_error(self):
        self.edit_run(1, repeat_of="pull.csv")
        self.assert_manifest_problem("repeat_of", "pull.csv")

    def test_a_repeat_of_a_repeat_is_an_error(self):
        self.edit_run(2, repeat_of="push_repeat.csv")
        self.assert_manifest_problem("repeat_of", "itself a repeat")

    def test_a_repeat_of_itself_is_an_error(self):
        self.edit_run(1, repeat_of="push_repeat.csv")
        self.assert_manifest_problem("repeat_of", "itself")

    def test_no_fit_run_is_an_error(self):
        for number in range(3):
            self.edit_run(number, split="validation")
        self.assert_manifest_problem("split: fit")

    def test_no_validation_run_is_a_warning(self):
        self.edit_run(3, split="fit")
        self.assert_manifest_problem("validation", severity="warning")

    def test_a_duplicate_file_is_an_error(self):
        self.edit_run(3, file="./push.csv")
        self.assert_problem("duplicate", "1 and 4", file="./push.csv")

    def test_a_path_that_leaves_the_folder_is_an_error(self):
        for file in ("../push.csv", "/etc/passwd", "a/../../push.csv"):
            with self.subTest(file):
                self.edit_run(3, file=file)
                self.assert_problem("leaves", file=file)

    def test_a_leg_bench_needs_its_nominal_numbers(self):
        self.rewrite(make_leg_bench())
        self.describe(nominal={"mass_kg": -1})
        self.assert_manifest_problem("nominal.mass_kg", "-1", only=False)
        self.assert_manifest_problem(
            "nominal.viscous_N_s_m", "missing", only=False
        )

    def test_a_controller_needs_both_gains(self):
        self.rewrite(make_leg_bench())
        self.describe(control={"kp_1_s": 160.0})
        self.assert_manifest_problem("control.kv_N_s_m", "missing")

    def test_a_leg_bench_needs_no_controller_and_a_pad_no_nominal(self):
        self.rewrite(make_leg_bench())
        self.describe(control=None)
        self.assertEqual(CheckCampaign(self.path), [])
        self.rewrite(make_pad_bench())
        self.describe(nominal={"stiffness_N_m": "stiff"})
        self.assert_manifest_problem("nominal.stiffness_N_m", "'stiff'")


class TestTable(CheckTest):
    def test_a_missing_file_is_an_error(self):
        (self.path / "push.csv").unlink()
        self.assert_problem("no such file")

    def test_a_folder_in_place_of_a_file_is_an_error(self):
        (self.path / "push.csv").unlink()
        (self.path / "push.csv").mkdir()
        self.assert_problem("cannot be read")

    def test_an_empty_file_is_an_error(self):
        (self.path / "push.csv").write_text("\n")
        self.assert_problem("empty")

    def test_a_header_without_rows_is_an_error(self):
        self.put_lines(self.lines()[:1])
        self.assert_problem("only a header")

    def test_a_single_row_is_an_error(self):
        self.put_lines(self.lines()[:2])
        self.assert_problem("1 data row;", "10 or more")

    def test_a_file_without_header_is_an_error(self):
        self.put_lines(self.lines()[1:])
        self.assert_problem("no header")

    def test_bytes_that_are_no_text_are_an_error(self):
        for data in (b"PK\x03\x04\x00\x00", b"time_s\n\xff\xfe\n"):
            with self.subTest(data):
                (self.path / "push.csv").write_bytes(data)
                self.assert_problem("text")

    def test_semicolons_are_an_error(self):
        text = (self.path / "push.csv").read_text()
        (self.path / "push.csv").write_text(text.replace(",", ";"))
        self.assert_problem("commas")

    def test_a_duplicate_header_column_is_an_error(self):
        lines = self.lines()
        lines = [f"{line},{line.split(',')[1]}" for line in lines]
        self.put_lines(lines)
        self.assert_problem("2 times", column="leg1_force_command_N")

    def test_a_column_without_a_name_is_an_error(self):
        self.put_lines([f"{line}," for line in self.lines()])
        self.assert_problem("no name")

    def test_every_missing_column_is_reported(self):
        header, *rows = self.lines()
        header = header.replace("ring2_force_y_N", "a")
        header = header.replace("leg2_length_m", "b")
        self.put_lines([header, *rows])
        for column in ("ring2_force_y_N", "leg2_length_m"):
            self.assert_problem("missing column", column=column, only=False)
        self.assertEqual(len(CheckCampaign(self.path)), 2)

    def test_a_marker_that_was_not_recorded_is_a_warning(self):
        header, *rows = self.lines()
        self.put_lines([header.replace("torso_x_m", "a"), *rows])
        self.assert_problem(
            "missing column", column="torso_x_m", severity="warning"
        )
        self.put_lines([header.replace("torso_x_m", "torso_x_mm"), *rows])
        self.assert_problem("did you mean 'torso_x_mm'", column="torso_x_m")

    def test_another_unit_gets_a_hint(self):
        cases = ("leg1_length_mm", "leg1_length", "Leg1_Length_m")
        text = (self.path / "push.csv").read_text()
        for name in cases:
            with self.subTest(name):
                spoilt = text.replace("leg1_length_m", name)
                (self.path / "push.csv").write_text(spoilt)
                self.assert_problem(
                    "missing", f"did you mean '{name}'", column="leg1_length_m"
                )

    def test_a_misspelt_column_gets_a_hint(self):
        text = (self.path / "push.csv").read_text()
        for name, meant in (
            ("leg1_lenght_m", "leg1_length_m"),
            ("ring2_froce_y_N", "ring2_force_y_N"),
        ):
            with self.subTest(name):
                (self.path / "push.csv").write_text(text.replace(meant, name))
                self.assert_problem(f"did you mean '{name}'", column=meant)

    def test_another_leg_or_axis_is_no_misspelling(self):
        header = ["leg7_length_m", "ring2_force_z_N", "leg1_lengthh_m"]
        found = near_misses(
            ["leg1_length_m", "leg2_length_m", "ring2_force_y_N"], header
        )
        self.assertEqual(
            found,
            {
                "leg1_length_m": "leg1_lengthh_m",
                "leg2_length_m": None,
                "ring2_force_y_N": None,
            },
        )

    def test_a_column_that_is_not_needed_and_misspelt_is_a_warning(self):
        text = (self.path / "push.csv").read_text()
        spoilt = text.replace("torso_x_m", "torsoo_x_m")
        (self.path / "push.csv").write_text(spoilt)
        self.assert_problem(
            "did you mean 'torsoo_x_m'", column="torso_x_m", severity="warning"
        )

    def test_a_recording_of_another_device_is_one_error(self):
        self.describe(device="brace")
        problems = [p for p in CheckCampaign(self.path) if p.file == "free.csv"]
        self.assertEqual(len(problems), 1)
        self.assertIn("leg18_length_m", problems[0].message)

    def test_rows_of_the_wrong_width_are_told_once(self):
        lines = self.lines()
        lines[7] = lines[7] + ",1.0"
        lines[9] = lines[9].rsplit(",", 1)[0]
        self.put_lines(lines)
        self.assert_problem("24 fields instead of 23", "2 rows", row=7)

    def test_a_blank_line_in_the_middle_is_an_error(self):
        lines = self.lines()
        lines.insert(5, "")
        self.put_lines(lines)
        self.assert_problem("instead of 23", row=5)

    def test_a_file_cut_in_the_middle_of_a_row_is_an_error(self):
        lines = self.lines()
        whole = lines[-1]
        for kept in (len(whole) // 2, len(whole) - 2, 1):
            with self.subTest(kept):
                self.put_lines([*lines[:-1], whole[:kept]], end="")
                self.assert_problem("cut off", row=ROWS)

    def test_a_field_that_is_no_number_is_reported_with_its_place(self):
        self.edit_cell(12, "torso_y_m", "0.0O1")
        self.edit_cell(20, "torso_y_m", "n/a")
        self.assert_problem(
            "'0.0O1' is not a number", "2 rows", row=12, column="torso_y_m"
        )

    def test_an_empty_field_is_reported_with_its_place(self):
        self.edit_cell(12, "leg6_length_m", "")
        self.assert_problem(
            "empty", row=12, column="leg6_length_m", severity="warning"
        )
        for row in range(13, 19):
            self.edit_cell(row, "leg6_length_m", "")
        self.assert_problem("empty", row=12, column="leg6_length_m")

    def test_a_lost_value_or_row_is_put_back_on_a_straight_line(self):
        column = "ring2_force_y_N"
        whole = LoadCampaign(self.path).runs[0].channels
        line = 0.5 * (whole[column][30] + whole[column][32])
        self.edit_cell(32, column, "nan")
        found = LoadCampaign(self.path).runs[0].channels
        self.assertAlmostEqual(found[column][31], line, places=12)
        self.rewrite(make_campaign())
        lines = self.lines()
        del lines[32]
        self.put_lines(lines)
        found = LoadCampaign(self.path).runs[0].channels
        for name, values in found.items():
            self.assertEqual(len(values), len(whole[name]), name)
        self.assertAlmostEqual(found[column][31], line, places=12)
        np.testing.assert_allclose(found["time_s"], whole["time_s"], atol=1e-12)

    def test_a_nan_in_the_time_is_an_error(self):
        self.edit_cell(33, "time_s", "nan")
        self.assert_problem("finite", row=33, column="time_s", only=False)

    def test_a_nan_is_reported_with_file_row_and_column(self):
        for text in ("nan", "inf", "-inf", "1e999"):
            with self.subTest(text):
                self.rewrite(make_campaign())
                self.edit_cell(33, "ring2_force_z_N", text, "free.csv")
                self.assert_problem(
                    "finite",
                    file="free.csv",
                    row=33,
                    column="ring2_force_z_N",
                    severity="warning" if text == "nan" else "error",
                )

    def test_problems_of_different_kinds_are_all_found(self):
        self.edit_cell(3, "torso_x_m", "nan")
        self.edit_cell(3, "torso_z_m", "none")
        self.edit_cell(50, "time_s", "0.1")
        self.edit_cell(60, "leg4_length_m", "141.0")
        (self.path / "free.csv").unlink()
        expected = [
            ("push.csv", 3, "torso_x_m"),
            ("push.csv", 3, "torso_z_m"),
            ("push.csv", 50, "time_s"),
            ("push.csv", 60, "leg4_length_m"),
            ("free.csv", None, None),
        ]
        problems = CheckCampaign(self.path)
        self.assertEqual(
            [(p.file, p.row, p.column) for p in problems], expected
        )


class TestSamples(CheckTest):
    def test_time_that_does_not_increase_is_told_with_its_row(self):
        lines = self.lines()
        lines.insert(101, lines[100])
        self.put_lines(lines)
        self.assert_problem("does not increase", row=101, column="time_s")

    def test_another_rate_is_an_error(self):
        self.edit_channel("time_s", lambda time: time * 1.03)
        self.assert_problem("194.175 Hz", "200", column="time_s")
        self.edit_channel("time_s", lambda time: time * 1.01)
        self.assertEqual(CheckCampaign(self.path), [])

    def test_a_gap_in_time_is_told_with_its_row(self):
        lines = self.lines()
        del lines[201:211]
        self.put_lines(lines)
        self.assert_problem("gap", "0.055 s", row=201, column="time_s")

    def test_millimetres_are_found_out(self):
        for column in ("leg2_length_m", "torso_y_m", "ring2_y_desired_m"):
            with self.subTest(column):
                self.edit_channel(column, lambda length: 1000.0 * length)
                values = make_campaign().runs[0].channels[column]
                low, high = (0.03, 0.5) if "leg" in column else (-0.2, 0.2)
                outside = (1e3 * values < low) | (1e3 * values > high)
                self.assert_problem(
                    "plausible",
                    "is the unit m?",
                    f"of {np.count_nonzero(outside)} rows",
                    row=int(np.argmax(outside)) + 1,
                    column=column,
                )

    def test_millinewtons_are_found_out(self):
        self.edit_channel("ring2_force_y_N", lambda force: 1e3 * force)
        force = make_campaign().runs[0].channels["ring2_force_y_N"]
        self.assert_problem(
            "is the unit N?",
            row=int(np.argmax(np.abs(force) > 1.0)) + 1,
            column="ring2_force_y_N",
        )

    def test_a_constant_channel_is_a_warning(self):
        columns = ("leg3_length_m", "torso_y_m", "ring2_vy_desired_m_s")
        for column in columns:
            with self.subTest(column):
                self.edit_channel(column, lambda x: np.full_like(x, 0.14))
                self.assert_problem(
                    "constant at 0.14", column=column, severity="warning"
                )

    def test_channels_that_may_rest_are_not_called_constant(self):
        campaign = make_campaign()
        hold, _, free, validation = campaign.runs
        still = dict(hold.channels)
        absent = dict(free.channels)
        for name in still:
            if "desired" in name or "virtual" in name:
                still[name] = np.zeros(ROWS)
            if name.startswith(("torso", "ring2_force")):
                absent[name] = np.zeros(ROWS)
        runs = (
            replace(hold, channels=still),
            replace(free, channels=absent),
            validation,
        )
        self.rewrite(replace(campaign, runs=runs))
        self.assertEqual(CheckCampaign(self.path), [])

    def test_a_command_at_its_limit_is_a_warning(self):
        def clip(command):
            return np.clip(60.0 * command, None, 120.0)

        self.edit_channel("leg6_force_command_N", clip)
        clipped = clip(make_campaign().runs[0].channels["leg6_force_command_N"])
        where = np.flatnonzero(clipped >= 120.0)
        self.assert_problem(
            f"saturated: {where.size} samples",
            "120 N",
            row=int(where[0]) + 1,
            column="leg6_force_command_N",
            severity="warning",
        )

    def test_a_command_with_a_flat_top_is_a_warning(self):
        self.edit_channel(
            "leg6_force_command_N", lambda command: np.clip(command, None, 3.0)
        )
        self.assert_problem(
            "139 samples flat",
            row=32,
            column="leg6_force_command_N",
            severity="warning",
        )

    def test_the_limits_can_be_given(self):
        limits = Limits(command=3.0)
        problems = CheckCampaign(self.path, limits)
        self.assertIn("limit of 3 N", problems[0].message)
        self.assertEqual(problems[0].severity, "warning")

    def test_a_force_reading_at_full_scale_is_a_warning(self):
        self.edit_channel(
            "ring2_force_y_N", lambda force: np.clip(10 * force, -50.0, 49.976)
        )
        self.assert_problem(
            "full scale",
            "50 N",
            row=66,
            column="ring2_force_y_N",
            severity="warning",
        )

    def test_a_drive_at_its_given_force_limit_is_a_warning(self):
        self.edit_channel(
            "force_command_N",
            lambda force: np.clip(2.0 * force, -351.5, 351.5),
            make_leg_bench(),
        )
        self.describe(
            control={"kp_1_s": 1.0, "kv_N_s_m": 1.0, "force_limit_N": 351.5}
        )
        self.assert_problem(
            "limit of 351.5 N",
            file="fit.csv",
            row=3,
            column="force_command_N",
            severity="warning",
        )

    def test_square_waves_of_an_open_loop_drive_are_not_saturation(self):
        self.edit_channel(
            "force_command_N",
            lambda force: 50.0 * np.sign(force),
            make_leg_bench(),
        )
        self.describe(control=None)
        self.assertEqual(CheckCampaign(self.path), [])

    def test_resting_at_the_extreme_is_not_a_flat_top(self):
        rest, rise = np.zeros(50), np.linspace(0.0, 1.0, 30)
        self.assertFalse(flat_extremes(np.r_[rest, rise]).any())
        clipped = np.r_[rise, np.ones(9), rise[::-1]]
        self.assertEqual(np.count_nonzero(flat_extremes(clipped)), 11)

    def test_a_copy_in_place_of_a_repeat_is_a_warning(self):
        self.put_lines(self.lines("push.csv"), "push_repeat.csv")
        self.assert_problem(
            "copy of push.csv", file="push_repeat.csv", severity="warning"
        )

    def test_a_repeat_with_another_reference_is_a_warning(self):
        self.edit_channel("ring2_y_desired_m", lambda y: 1.1 * y, run=1)
        self.assert_problem(
            "differs from push.csv",
            file="push_repeat.csv",
            column="ring2_y_desired_m",
            severity="warning",
        )


class TestSigns(CheckTest):
    def test_a_flipped_ring_force_is_an_error(self):
        self.edit_channel("ring2_force_y_N", np.negative)
        self.assert_problem("sign", column="ring2_force_y_N")

    def test_a_flipped_torso_marker_is_an_error(self):
        self.edit_channel("torso_y_m", np.negative)
        self.assert_problem("sign", column="torso_y_m")

    def test_flipped_leg_commands_are_an_error(self):
        campaign = make_campaign()
        run = campaign.runs[0]
        channels = {
            name: -values if "command" in name else values
            for name, values in run.channels.items()
        }
        runs = (replace(run, channels=channels), *campaign.runs[1:])
        self.rewrite(replace(campaign, runs=runs))
        self.assert_problem("sign", "leg commands")

    def test_a_free_run_says_nothing_about_the_force_sign(self):
        self.edit_channel("ring2_force_y_N", np.negative, run=2)
        self.assertEqual(CheckCampaign(self.path), [])

    def test_a_run_that_is_called_free_and_presses_is_told(self):
        campaign = make_campaign()
        pushed = campaign.runs[0].channels["ring2_force_y_N"]
        self.assertGreater(np.ptp(pushed), 4.0)
        runs = tuple(replace(r, contact=False) for r in campaign.runs)
        self.rewrite(replace(campaign, runs=runs))
        told = [p for p in CheckCampaign(self.path) if "torso" in p.message]
        self.assertEqual({p.severity for p in told}, {"warning"})
        self.assertEqual({p.column for p in told}, {"ring2_force_y_N"})
        self.assertIn(campaign.runs[0].file, {p.file for p in told})

    def test_a_torso_that_moves_by_itself_is_no_wrong_sign(self):
        campaign = make_campaign()
        channels = dict(campaign.runs[0].channels)
        for name in channels:
            if "desired" in name or "virtual" in name:
                channels[name] = np.zeros(ROWS)
        channels["ring2_force_y_N"] = -channels["ring2_force_y_N"]
        run = replace(campaign.runs[0], channels=channels)
        self.rewrite(replace(campaign, runs=(run, *campaign.runs[2:])))
        self.assertEqual(CheckCampaign(self.path), [])

    def test_a_flipped_drive_is_an_error(self):
        for column in ("force_command_N", "position_m"):
            with self.subTest(column):
                self.edit_channel(column, np.negative, make_leg_bench())
                self.assert_problem("sign", file="fit.csv", column=column)

    def test_a_flipped_pad_force_is_an_error(self):
        self.edit_channel("force_N", np.negative, make_pad_bench())
        self.assert_problem("sign", file="fit.csv", column="force_N")

    def test_a_passive_body_is_told_from_its_negative(self):
        # Oracle: the force is built from nonnegative factors, so it is
        # explained in full, and its negative not at all beyond chance.
        time = np.arange(2000) / RATE_HZ
        depth = np.sin(2.0 * np.pi * time)
        terms = np.column_stack([depth, np.gradient(depth) * RATE_HZ])
        force = terms @ [900.0, 30.0] + 5.0
        self.assertAlmostEqual(explained(force, terms), 1.0)
        self.assertLess(explained(-force, terms), 0.01)


class TestCommand(CheckTest):
    def run_command(self):
        parser = argparse.ArgumentParser()
        check.AddParser(parser.add_subparsers())
        args = parser.parse_args(["check", str(self.path)])
        with contextlib.redirect_stdout(io.StringIO()) as out:
            status = args.run(args)
        return status, out.getvalue().splitlines()

    def record(self):
        """A recording of the bench: what it says of itself is asked too."""
        for file in self.path.iterdir():
            file.unlink()
        for file in EXAMPLE.iterdir():
            shutil.copy(file, self.path)

    def test_a_sound_campaign_ends_with_status_0(self):
        self.record()
        status, lines = self.run_command()
        self.assertEqual(status, 0)
        self.assertIn("usable, 0 errors, 0 warnings", lines[-1])

    def test_warnings_alone_end_with_status_0(self):
        self.record()
        self.edit_run(4, split="fit")
        status, lines = self.run_command()
        self.assertEqual((status, len(lines)), (0, 2))
        self.assertIn("1 warning", lines[-1])

    def test_commands_that_do_not_follow_from_readings_are_an_error(self):
        self.record()
        lines = self.lines("push.csv")
        names = lines[0].split(",")
        a, b = (names.index(f"leg{k}_length_m") for k in (2, 3))
        names[a], names[b] = names[b], names[a]
        self.put_lines([",".join(names), *lines[1:]], "push.csv")
        status, lines = self.run_command()
        self.assertEqual((status, len(lines)), (2, 2))
        self.assertIn("leg 2 and leg 3 lengths exchanged", lines[0])

    def test_errors_are_printed_line_by_line_and_end_with_status_2(self):
        self.edit_cell(3, "torso_x_m", "inf")
        (self.path / "free.csv").unlink()
        status, lines = self.run_command()
        self.assertEqual((status, len(lines)), (2, 3))
        self.assertIn("push.csv, row 3 (line 4), column torso_x_m", lines[0])
        self.assertIn("2 errors", lines[-1])


class TestRecordedCampaigns(unittest.TestCase):
    @unittest.skipUnless(
        (SHARED / "campaigns").is_dir(), "no recorded campaigns beside the repo"
    )
    def test_recorded_bench_campaigns_raise_no_alarm(self):
        for path in sorted((SHARED / "campaigns").glob("open*")):
            with self.subTest(path.name):
                self.assertEqual(CheckCampaign(path), [])

    @unittest.skipUnless(
        (SHARED / "real" / "emps").is_dir(), "no real drive beside the repo"
    )
    def test_a_real_drive_raises_no_alarm(self):
        self.assertEqual(CheckCampaign(SHARED / "real" / "emps"), [])

    @unittest.skipUnless(
        (SHARED / "campaigns").is_dir(), "no recorded campaigns beside the repo"
    )
    def test_ten_runs_are_checked_in_well_under_a_second(self):
        path = sorted((SHARED / "campaigns").glob("open*"))[0]
        start = time.process_time()
        CheckCampaign(path)
        # Takes 0.2 s; the slack is for a slow machine.
        self.assertLess(time.process_time() - start, 1.0)


class TestHints(unittest.TestCase):
    def test_a_key_that_looks_like_a_missing_one_is_pointed_out(self):
        text = "format: brace-campaign/1\ndevice: brace\nrate_Hz: 200\n"
        _, problems = parse_manifest(text.encode())
        said = [str(p) for p in problems]
        self.assertTrue(any("did you mean rate_hz?" in s for s in said), said)
        _, problems = parse_manifest(b"recorded: {by: me}\nnotes: none\n")
        self.assertFalse(any("did you mean" in str(p) for p in problems))

    def test_keys_of_runs_and_of_numbers_are_pointed_out_too(self):
        text = (
            "format: brace-campaign/1\ndevice: leg bench\nrate_hz: 200\n"
            "nominal: {mas_kg: 3, viscous_N_s_m: 1}\n"
            "runs: [{file: a.csv, motion: push, contact: true, spilt: fit}]\n"
        )
        _, problems = parse_manifest(text.encode())
        said = " ".join(map(str, problems))
        self.assertIn("nominal: no key 'mas_kg', did you mean mass_kg?", said)
        self.assertIn("run 1: no key 'spilt', did you mean split?", said)

    def test_the_row_behind_one_that_is_early_is_no_gap(self):
        time = np.arange(100) / 200.0
        time[50] = 0.1
        found = check_time(time, 200.0, "push.csv")
        self.assertEqual([p.row for p in found], [51])
        self.assertIn("row 51 (line 52)", str(found[0]))


if __name__ == "__main__":
    unittest.main()

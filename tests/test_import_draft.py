"""Drafts of maps: guessed from names and units, and good enough to import."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import numpy as np
import yaml

from brace_drake.cli.main import main
from brace_drake.core.errors import CampaignError
from brace_drake.recording.importing.dialect import guess_options
from brace_drake.recording.importing.draft import (
    Draft,
    draft_map,
    guess_channels,
    read_draft,
    unit_of,
)
from brace_drake.recording.importing.mapped import ImportCampaign

GERMAN = "Messung 3\nDatum;26.11.2026\nZeit (ms);Weg [mm];Kraft_kN;Temp (C)\n"


def german(folder: str) -> Path:
    """A recording with a preamble, semicolons and decimal commas."""
    rows = [f"{10 * i};{i},5;0,{i:03d};21,{i % 10}" for i in range(60)]
    path = Path(folder) / "druck.csv"
    path.write_text(GERMAN + "\n".join(rows) + "\n")
    return path


class TestDraft(unittest.TestCase):
    def assert_guessed(self, names):
        """Columns, and the channels that they are to be taken for."""
        table = {name: np.arange(3.0) for name in names}
        found = {g.column: g.channel for g in guess_channels(table)[1]}
        self.assertEqual(found, names)

    def test_units_are_those_of_brackets_and_endings(self):
        for column, unit in (
            ("Time (ms)", "ms"),
            ("Stroke [mm]", "mm"),
            ("Kraft_kN", "kN"),
            ("input_torque_N_m", "N m"),
            ("speed_rad_s", "rad/s"),
            ("Angle [°]", "deg"),
            ("tq_mNm", "mN m"),
            ("Torque [N·m]", "N m"),
            ("n (1/min)", "rpm"),
            ("Load", ""),
            ("Temp (C)", ""),
        ):
            with self.subTest(column):
                self.assertEqual(unit_of(column), unit)

    def test_every_column_of_another_labs_bench_is_known(self):
        names = {"t [ms]": "time_s"}
        for k in range(1, 7):
            names[f"F_cmd_{k} [N]"] = f"leg{k}_force_command_N"
            names[f"L{k} [mm]"] = f"leg{k}_length_m"
        for axis in "xyz":
            names[f"LC_F{axis} [N]"] = f"ring2_force_{axis}_N"
            names[f"Mocap_T_{axis} [mm]"] = f"torso_{axis}_m"
        names["y_ref [mm]"] = "ring2_y_desired_m"
        names["y_imp [mm]"] = "ring2_y_virtual_m"
        table = {name: np.arange(3.0) for name in names}
        device, found = guess_channels(table)
        self.assertEqual(device, "bench stage 2")
        self.assertEqual({g.column: g.channel for g in found}, names)

    def test_channels_that_were_not_found_are_listed(self):
        names = ["t [s]", *(f"L{k} [mm]" for k in range(1, 7))]
        names += [f"F{axis} [N]" for axis in "xyz"]
        table = {name: np.arange(3.0) for name in names}
        text = draft_map(
            Draft(Path("lab/a.csv"), {}, table, *guess_channels(table))
        )
        self.assertIn("ring2_y_desired_m: which column is it?", text)
        self.assertRegex(text, r"# not found.*leg1_force_command_N")
        # The path is the one that was given.
        self.assertEqual(yaml.safe_load(text)["runs"][0]["file"], "lab/a.csv")

    def test_columns_are_guessed_by_words_and_units(self):
        names = {
            "t": "time_s",
            "Joint angle (deg)": "position_rad",
            "AngleSetpoint (deg)": "position_command_rad",
            "tau [N mm]": "torque_N_m",
            "pressure_bar": None,
        }
        self.assert_guessed(names)

    def test_a_stamp_is_a_time_in_the_unit_of_its_steps(self):
        for period, unit in ((0.01, ""), (5.0, "ms"), (5e3, "us"), (5e6, "ns")):
            stamps = 1.7e9 + period * np.arange(100.0)
            _, (found,) = guess_channels({"stamp": stamps})
            self.assertEqual((found.channel, found.unit), ("time_s", unit))

    def test_a_current_is_no_angle_and_a_goal_is_a_command(self):
        names = {
            "sec": "time_s",
            "i_q_A": None,
            "goal_deg": "position_command_rad",
            "present_deg": "position_rad",
        }
        self.assert_guessed(names)

    def test_motor_and_load_are_told_apart(self):
        for names in (
            {
                "time_s": "time_s",
                "motor_position_rad": "motor_position_rad",
                "position_rad": "position_rad",
            },
            {
                "t": "time_s",
                "motor pos (mm)": "motor_position_m",
                "joint pos (mm)": "position_m",
            },
        ):
            self.assert_guessed(names)

    def test_where_words_say_nothing_units_do_after_all_words(self):
        names = {
            "time": "time_s",
            "gap_mm": None,
            "cmd_mm": "position_command_m",
            "position_mm": "position_m",
            "pot_N": "force_N",
        }
        self.assert_guessed(names)

    def test_a_channel_is_given_once(self):
        table = {n: np.arange(3.0) for n in ("force_N", "load_N", "time_s")}
        found = [g.channel for g in guess_channels(table)[1]]
        self.assertEqual(found, ["force_N", None, "time_s"])

    def test_the_dialect_of_a_file_is_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            found = guess_options(german(folder))
        wanted = {"delimiter": ";", "decimal": ",", "skip_lines": 2}
        self.assertEqual(found, wanted)

    def test_a_bench_is_seen_by_its_six_legs(self):
        i = np.arange(60.0)
        table = {
            "t": 5.0 * i,
            **{f"LegLen{k}": 140.0 + np.sin(i) for k in range(1, 7)},
            **{f"u{k} [N]": i for k in range(1, 7)},
            **{f"F{a}": i for a in "xyz"},
            "Yref_mm": np.sin(i),
            "marker x": 1e-4 * i,
            "torso_y_m": 1e-4 * i,
            "Temp": i,
        }
        device, found = guess_channels(table)
        self.assertEqual(device, "bench stage 2")
        wanted = {
            "t": ("time_s", "ms"),
            **{f"LegLen{k}": (f"leg{k}_length_m", "mm") for k in range(1, 7)},
            **{
                f"u{k} [N]": (f"leg{k}_force_command_N", "N")
                for k in range(1, 7)
            },
            **{f"F{a}": (f"ring2_force_{a}_N", "") for a in "xyz"},
            "Yref_mm": ("ring2_y_desired_m", "mm"),
            "marker x": ("torso_x_m", ""),
            "torso_y_m": ("torso_y_m", "m"),
            "Temp": (None, ""),
        }
        self.assertEqual({g.column: (g.channel, g.unit) for g in found}, wanted)

    def test_blanks_part_columns_where_nothing_else_does(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.txt"
            path.write_text("t  x\n" + "0.1   2.5\n0.2  \t 3\n" * 9)
            self.assertEqual(guess_options(path), {"delimiter": " "})

    def test_a_draft_is_a_map_that_imports(self):
        with tempfile.TemporaryDirectory() as folder:
            path = german(folder)
            text = draft_map(read_draft(path))
            (Path(folder) / "a.map.yaml").write_text(text)
            campaign = ImportCampaign(Path(folder) / "a.map.yaml")
        (run,) = campaign.runs
        i = np.arange(60)
        np.testing.assert_allclose(run.channels["time_s"], 1e-2 * i)
        np.testing.assert_allclose(run.channels["position_m"], 1e-3 * (i + 0.5))
        np.testing.assert_allclose(run.channels["force_N"], i)
        self.assertIn('# input_Temp_C: "Temp (C)"', text)

    def test_the_command_prints_it(self):
        out = io.StringIO()
        with (
            tempfile.TemporaryDirectory() as folder,
            contextlib.redirect_stdout(out),
        ):
            status = main(["import", "--init", str(german(folder))])
        self.assertEqual(status, 0)
        self.assertEqual(
            set(yaml.safe_load(out.getvalue())["columns"]),
            {"time_s", "position_m", "force_N"},
        )

    def test_what_is_no_recording_is_refused_in_a_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.csv"
            for text in ("", "a\n", "a,b\nx,y\n"):
                path.write_text(text)
                with self.subTest(text), self.assertRaises(CampaignError):
                    draft_map(read_draft(path))


if __name__ == "__main__":
    unittest.main()

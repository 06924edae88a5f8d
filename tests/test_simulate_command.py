"""`brace-drake simulate`: a campaign from a scenario and a reference."""

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.core.resources import scenario_path
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MOTIONS, MakeMotion
from brace_drake.devices.motions.reference import (
    LoadReference,
    LoadReferences,
    common_rate,
    format_reference,
)
from brace_drake.devices.motions.times import MOST_ROWS
from brace_drake.effects.registry import find_effect
from brace_drake.link.operation.campaign import LoadPlan
from brace_drake.recording import LoadCampaign, Problem
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.load import SaveScenario
from tests.commands import run_command
from tests.shared_data import EXAMPLE
from tests.test_station import smooth_push

# Motions that are over before they cost a test its time.
SHORT = {
    "free_hold": ("still", 1, ("quiet_hold",)),
    "push": ("a push", 5, ("push", -0.005, 3.0)),
    "push_fast": ("a push", 5, ("push", -0.005, 2.0)),
}
HEAD = "time_s,ring2_y_desired_m,ring2_vy_desired_m_s,ring2_ay_desired_m_s2"


def write_reference(path, head=HEAD, rows=None):
    time, samples = smooth_push(0.5, -0.005)
    rows = np.column_stack([time, samples]) if rows is None else rows
    np.savetxt(path, rows, "%.9f", ",", header=head, comments="")
    return path


class TestSimulate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.card = find_effect("relaxation")
        scenario = BenchScenario(time_step=5e-4)
        values = np.array([3000.0, 0.7])
        scenario.effects = [describe_use(cls.card, values)]
        cls.scenario, cls.file = scenario, cls.folder / "some.scenario.yaml"
        SaveScenario(scenario, cls.file)
        cls.reference = write_reference(cls.folder / "push.csv")

    def simulate(self, name, *more, motion=None):
        motion = motion or self.reference
        out = self.folder / name
        code, text, error = run_command(
            "simulate", self.file, "--motion", motion, "--out", out, *more
        )
        self.assertEqual(code, 0, error)
        self.assertIn(str(out), text)
        return LoadCampaign(out)

    def test_the_recording_is_the_rollout_of_the_scenario_with_its_effects(
        self,
    ):
        (recorded,) = self.simulate("exact").runs
        twin = BenchTwin(self.scenario)
        nominal = np.array([p.nominal for p in twin.subject])
        rollout = twin.simulate(twin.motion(recorded), nominal)
        measured = twin.measured(recorded)
        # The file has 1e-5 N and 1e-8 m; the reference's own decimals, 1e-9
        # m and 1e-6 m/s^2, act through a stiffness of 6 kN/m.
        error = np.abs(measured - rollout).max(axis=0)
        self.assertLess(error[[*range(6), 12, 13, 14]].max(), 5e-5)
        self.assertLess(error[[*range(6, 12), *range(15, 19)]].max(), 2e-8)
        self.assertGreater(np.abs(measured[:, 13]).max(), 3.0)

    def test_check_accepts_what_is_written(self):
        self.simulate("checked", "--noise-seed", 4)
        code, text, _ = run_command("check", self.folder / "checked")
        self.assertEqual(code, 0)
        self.assertIn("0 errors", text)

    def test_a_plan_becomes_one_campaign(self):
        plan = self.folder / "plan.yaml"
        plan.write_text(
            "format: brace-plan/1\nruns:\n- {motion: free_hold}\n"
            "- {motion: push}\n- {motion: push, repeat: true}\n"
            "- {motion: push_fast, split: validation}\n"
        )
        out = self.folder / "planned"
        words = ("simulate", self.file, "--plan", plan, "--out", out)
        with mock.patch.dict(
            "brace_drake.devices.motions.library._LIBRARY", SHORT
        ):
            status, _, error = run_command(*words)
        self.assertEqual(status, 0, error)
        self.assertEqual(run_command("check", out)[0], 0)
        campaign = LoadCampaign(out)
        rows = [
            (r.file, r.contact, r.split, r.repeat_of) for r in campaign.runs
        ]
        self.assertEqual(
            rows,
            [
                ("free_hold.csv", False, "fit", None),
                ("push.csv", True, "fit", None),
                ("push_2.csv", True, "fit", "push.csv"),
                ("push_fast.csv", True, "validation", None),
            ],
        )
        # The motion is the same, the noise is not.
        first, second = (r.channels for r in campaign.runs[1:3])
        for name in ("time_s", "ring2_y_desired_m"):
            np.testing.assert_array_equal(first[name], second[name])
        self.assertFalse(
            np.array_equal(first["leg1_length_m"], second["leg1_length_m"])
        )

    def test_a_plan_shows_no_single_run(self):
        out = self.folder / "shown"
        status, _, error = run_command(
            "simulate", self.file, "--plan", "--html", "a", "--out", out
        )
        self.assertEqual((status, error.count("\n")), (2, 1))
        self.assertIn("--plan records several runs", error)

    def test_the_plan_of_a_plan_command_is_one_too(self):
        file = self.folder / "plan.json"
        file.write_text(
            '{"format": "brace-plan/1", "runs": ["push", "stairs"]}'
        )
        self.assertEqual([r.motion for r in LoadPlan(file)], ["push", "stairs"])

    def test_a_campaign_stands_for_the_scenario_that_it_names(self):
        named = self.folder / "named"
        self.simulate("named", "--noise-seed", "3")
        (named / "own.yaml").write_text(self.file.read_text())
        manifest = named / "campaign.yaml"
        manifest.write_text(manifest.read_text() + "scenario: own.yaml\n")
        out = self.folder / "from_campaign"
        status, _, error = run_command(
            "simulate", named, "--motion", self.reference, "--out", out,
            "--noise-seed", "3",
        )  # fmt: skip
        self.assertEqual(status, 0, error)
        first, again = (p / "push.csv" for p in (named, out))
        self.assertEqual(first.read_text(), again.read_text())

    def test_the_seed_decides_the_noise(self):
        column = "leg1_length_m"
        runs = [
            self.simulate(f"noise{i}", "--noise-seed", seed).runs[0]
            for i, seed in enumerate((1, 1, 2))
        ]
        first, again, other = (r.channels[column] for r in runs)
        np.testing.assert_array_equal(first, again)
        self.assertGreater(np.abs(first - other).max(), 1e-6)
        # Noise of 5 um, and rounding to 10 um; 101 samples, and what of the
        # force's noise the loop turns into motion.
        spread = (first - other).std() / np.sqrt(2.0)
        expected = np.hypot(5e-6, 1e-5 / 12**0.5)
        self.assertAlmostEqual(spread / expected, 1.0, delta=0.25)

    def test_a_free_motion_has_no_torso(self):
        free = write_reference(self.folder / "free_push.csv")
        (recorded,) = self.simulate("free", motion=free).runs
        self.assertFalse(recorded.contact)
        force = recorded.channels["ring2_force_y_N"]
        np.testing.assert_array_equal(force, 0.0)

    def test_a_page_may_not_replace_the_campaign(self):
        out = self.folder / "paged"
        status, _, errors = run_command(
            *("simulate", self.file, "--motion", "push", "--out", out),
            *("--html", out / "campaign.yaml"),
        )
        self.assertEqual(status, 2)
        self.assertIn("within the campaign", errors)
        self.assertFalse(out.exists())

    def test_problems_are_told_in_one_line(self):
        folder = self.folder
        time, samples = smooth_push(0.5)
        rows = np.column_stack([time, samples])
        uneven, back = rows.copy(), rows.copy()
        uneven[50:, 0] += 0.002
        back[50, 0] = back[49, 0]
        jump, torn, idle = rows.copy(), rows.copy(), rows.copy()
        jump[50:, 1] = 0.5
        torn[50:, 1] += 0.01
        idle[:, 2] = 0.0
        fine, long = rows[:90].copy(), rows[:90].copy()
        fine[:, 0] *= 1e-6 / 0.005
        fine[:, 1:] = 0.0
        long[:, 0] *= 1000.0 / 0.005
        many = np.zeros((MOST_ROWS + 1, 4))
        many[:, 0] = np.arange(len(many)) * 0.002
        short = rows[:9]
        leg = scenario_path("leg_bench.scenario.yaml")
        lacking = HEAD.replace("ring2_ay", "ring2_az")
        cases = (
            (self.file, "stair", "did you mean stairs"),
            (self.file, folder / "none.csv", "none.csv: cannot be read"),
            (
                self.file,
                write_reference(folder / "a.csv", lacking),
                "a.csv: no column ring2_ay_desired_m_s2",
            ),
            (
                self.file,
                write_reference(folder / "b.csv", rows=uneven),
                "b.csv: time_s is not evenly",
            ),
            (
                self.file,
                write_reference(folder / "c.csv", rows=back),
                "c.csv: time_s does not increase",
            ),
            (
                self.file,
                write_reference(folder / "d.csv", rows=jump),
                "column ring2_y_desired_m: 0.5 is outside the plausible range",
            ),
            (
                self.file,
                write_reference(folder / "e.csv", rows=torn),
                "e.csv: row 51 (line 52), ring2_vy_desired_m_s is",
            ),
            (
                self.file,
                write_reference(folder / "f.csv", rows=idle),
                "allowed: its derivative",
            ),
            (
                self.file,
                write_reference(folder / "g.csv", rows=fine),
                "g.csv: time_s goes on by 1e-06 s; allowed: 0.0001 s or more",
            ),
            (
                self.file,
                write_reference(folder / "h.csv", rows=long),
                "h.csv: time_s lasts 89000 s; allowed: 600 s or less",
            ),
            (
                self.file,
                write_reference(folder / "i.csv", rows=many),
                "i.csv: 120001 rows; allowed: 120000 or fewer",
            ),
            (
                self.file,
                write_reference(folder / "j.csv", rows=short),
                "j.csv: time_s lasts 0.04 s, which is 9 rows at 200 Hz;"
                " allowed: 10 rows or more, 0.045 s",
            ),
            (leg, "push", "this is a 'leg bench'"),
            (folder / "no.yaml", "push", "no.yaml: cannot be read"),
        )
        for scenario, motion, part in cases:
            with self.subTest(part=part):
                code, _, error = run_command(
                    "simulate",
                    scenario,
                    "--motion",
                    motion,
                    "--out",
                    folder / "nothing",
                )
                self.assertEqual(code, 2)
                self.assertEqual(error.count("\n"), 1)
                self.assertIn(part, error)
        self.assertFalse((folder / "nothing").exists())

    def test_the_shortest_motion_that_is_taken_makes_a_usable_campaign(self):
        time, samples = smooth_push(0.5, -0.005)
        rows = np.column_stack([time, samples])[:10]
        motion = write_reference(self.folder / "shortest.csv", rows=rows)
        (recorded,) = self.simulate("shortest", motion=motion).runs
        self.assertEqual(len(recorded.time_s), 10)

    def test_a_motion_by_the_clock_of_1970_is_the_motion_from_zero(self):
        time, samples = smooth_push(0.5, -0.005)
        rows = np.column_stack([time + 1.7e9, samples])
        motion = write_reference(self.folder / "clock.csv", rows=rows)
        (recorded,) = self.simulate("clock", motion=motion).runs
        (own,) = self.simulate("zero").runs
        name = "ring2_force_y_N"
        # A microsecond of 6 kN/m at 0.02 m/s, and the file's last digit.
        np.testing.assert_allclose(
            recorded.channels[name], own.channels[name], rtol=0, atol=2e-4
        )

    def test_a_twin_that_does_what_check_refuses_is_no_success(self):
        out = self.folder / "refused"
        problem = Problem("error", "push.csv", "too strong")
        with mock.patch(
            "brace_drake.recording.CheckCampaign",
            return_value=[problem],
        ):
            code, text, error = run_command(
                "simulate", self.file, "--motion", self.reference, "--out", out
            )
        self.assertEqual((code, error.count("\n")), (2, 1))
        self.assertIn("not usable, error: push.csv: too strong", error)
        self.assertIn(str(out), text)

    def test_a_place_that_is_taken_is_refused_before_the_run(self):
        taken = self.folder / "taken"
        taken.mkdir()
        (taken / "notes.txt").write_text("kept")
        with mock.patch("brace_drake.model.simulate.RecordBrace") as record:
            code, _, error = run_command(
                "simulate", self.file, "--motion", "push", "--out", taken
            )
        record.assert_not_called()
        self.assertEqual((code, error.count("\n")), (2, 1))
        self.assertIn("taken: exists and is not empty", error)


class TestReferences(unittest.TestCase):
    def test_motions_of_the_library_are_references_at_20_hz_too(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in MOTIONS:
                with self.subTest(motion=name):
                    run = MakeMotion(name).run
                    head, *rows = format_reference(run).splitlines()
                    path = Path(folder) / f"{name}.csv"
                    path.write_text("\n".join([head, *rows[::10], ""]))
                    LoadReference(path)

    def test_a_campaign_gives_the_references_of_its_fit_runs(self):
        runs = LoadReferences(EXAMPLE)
        names = {r.name for r in runs}
        self.assertIn("stairs", names)
        self.assertNotIn("validation_push", names)
        self.assertAlmostEqual(common_rate(runs), 200.0)

    def test_a_folder_of_files_gives_them_all(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(CampaignError, "no reference"):
                LoadReferences(folder)
            write_reference(Path(folder) / "push.csv")
            write_reference(Path(folder) / "free_push.csv")
            free, push = LoadReferences(folder)
            self.assertEqual((free.contact, push.contact), (False, True))
            time, samples = smooth_push(0.5)
            rows = np.column_stack([time, samples])[::2]
            path = write_reference(Path(folder) / "slow.csv", rows=rows)
            with self.assertRaisesRegex(CampaignError, "one rate"):
                common_rate((push, LoadReference(path)))


if __name__ == "__main__":
    unittest.main()

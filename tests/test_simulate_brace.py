"""Recordings of the whole brace, or of the stages that a scenario picks."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.core.resources import scenario_path
from brace_drake.devices.motions.reference import reference_columns
from brace_drake.kinematics import find_task_coordinates, leg_lengths
from brace_drake.model.simulate import RecordBrace, SimulateBrace
from brace_drake.recording import LoadCampaign
from brace_drake.recording.manifest import parse_manifest
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_geometry
from brace_drake.scenario.load import LoadScenario, SaveScenario
from tests.commands import run_command
from tests.meshcat_page import read_commands
from tests.test_station import smooth_push


def reference(distances, seconds=0.5, contact=True):
    """Smooth pushes of some rings, m, keyed by ring."""
    channels = {}
    for ring, distance in distances.items():
        time, samples = smooth_push(seconds, distance)
        columns = reference_columns(ring)
        channels |= dict(zip(columns, samples.T, strict=True))
    return Run(
        "p.csv", contact, "push", None, "fit", {"time_s": time, **channels}
    )


class TestRecordBrace(unittest.TestCase):
    def test_leg_lengths_are_those_of_the_rings_poses(self):
        scenario = BraceScenario()
        log = SimulateBrace(scenario, reference({1: 1e-3, 3: -2e-3}))
        geometry = pack_geometry(scenario)
        for k in (0, 50, 100):
            expected = leg_lengths(geometry, log.X[k].ravel())
            np.testing.assert_allclose(
                log.leg_length[k], np.ravel(expected), atol=1e-12
            )
        # A tick reads, then the plant steps: v is the rate of X.
        rate = np.gradient(log.X[:, :, :3], log.time, axis=0)
        np.testing.assert_allclose(log.v[2:-2], rate[2:-2], atol=5e-4)
        y = log.X[-1, :, 1]
        np.testing.assert_allclose(y, [1e-3, 0.0, -2e-3], atol=1.5e-3)
        self.assertGreater(y[0] - y[1], 0.0)
        self.assertLess(y[2] - y[1], -5e-4)

    def test_without_the_torso_no_ring_feels_a_force(self):
        free = reference({2: -0.005}, 0.2, contact=False)
        channels = RecordBrace(BraceScenario(), free).channels
        for ring in (1, 2, 3):
            force = channels[f"ring{ring}_force_y_N"]
            np.testing.assert_array_equal(force, 0.0)

    def test_what_no_brace_can_do_is_refused(self):
        scenario = BraceScenario(stages=[2])
        with self.assertRaisesRegex(CampaignError, "ring3_y.* ring 3; .*: 2"):
            SimulateBrace(scenario, reference({3: 1e-3}))
        with self.assertRaisesRegex(BraceError, r"leg \d+ is .* stroke allows"):
            short = replace(scenario.leg, stroke=0.004)
            SimulateBrace(replace(scenario, leg=short), reference({2: -0.01}))


class TestCommand(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def record(self, name, stages, *more):
        file = self.folder / f"{name}.scenario.yaml"
        SaveScenario(BraceScenario(stages=stages), file)
        motion = self.folder / "push.csv"
        channels = reference({2: -0.005}).channels
        head = ",".join(channels)
        rows = np.column_stack(list(channels.values()))
        np.savetxt(motion, rows, "%.9f", ",", header=head, comments="")
        out = self.folder / name
        words = ("simulate", file, "--motion", motion, "--out", out, *more)
        code, _, error = run_command(*words)
        self.assertEqual(code, 0, error)
        return out

    def test_check_accepts_all_stages_and_some(self):
        for stages, device, legs in (
            ([1, 2, 3], "brace", range(1, 19)),
            ([1, 2], "brace", range(1, 13)),
            ([2, 3], "brace", range(7, 19)),
            ([2], "bench stage 2", range(1, 7)),
        ):
            name = "".join(map(str, stages))
            out = self.record(name, stages, "--noise-seed", 1)
            code, text, _ = run_command("check", out)
            campaign = LoadCampaign(out)
            columns = campaign.runs[0].channels
            found = [c for c in columns if c.endswith("_length_m")]
            with self.subTest(stages=stages):
                self.assertEqual(code, 0, text)
                self.assertIn("0 errors", text)
                self.assertEqual(campaign.device, device)
                self.assertEqual(found, [f"leg{k}_length_m" for k in legs])

    def test_a_patients_torso_presses_as_its_linear_pads_say(self):
        torso, file = self.folder / "torso", self.folder / "soft.scenario.yaml"
        words = ("personalize", scenario_path("torso_nominal.measures.yaml"))
        code, _, error = run_command(
            *words, "--resolution", 0.03, "--out", torso
        )
        self.assertEqual(code, 0, error)
        scenario = LoadScenario(torso / "brace.scenario.yaml")
        for pads in scenario.contact:
            pads.model = "hydroelastic"
        SaveScenario(scenario, file)
        motion = self.folder / "push.csv"
        channels = reference({2: -0.001}, 0.25).channels
        rows = np.column_stack(list(channels.values()))
        head = ",".join(channels)
        np.savetxt(motion, rows, "%.9f", ",", header=head, comments="")
        out = self.folder / "out"
        words = ("--motion", motion, "--out", out, "--torso", torso)
        page = self.folder / "page.html"
        code, _, error = run_command("simulate", file, *words, "--html", page)
        self.assertEqual(code, 0, error)
        # Drawn is this torso, not a plain one.
        (drawn,) = (
            c["object"]
            for c in read_commands(page.read_text())
            if c["type"] == "set_object" and c["path"] == "/torso/body"
        )
        text = drawn["geometries"][0]["data"]
        self.assertEqual(text, (torso / "torso.obj").read_text())
        (recorded,) = LoadCampaign(out).runs
        lengths = recorded.stack([f"leg{k}_length_m" for k in range(1, 19)])
        X = find_task_coordinates(pack_geometry(scenario), lengths[-1])
        # Both pads touch, 2 k; the damper, at the end, has come to rest.
        off = X[7] - recorded.channels["torso_y_m"][-1]
        force = recorded.channels["ring2_force_y_N"][-1]
        k = scenario.contact.ring2.stiffness
        self.assertLess(force, -1.0)
        self.assertAlmostEqual(force / (2.0 * k * off), 1.0, delta=0.1)
        words = ("--motion", motion, "--out", self.folder / "other")
        words = (*words, "--torso", torso)
        bench = scenario_path("bench.scenario.yaml")
        code, _, error = run_command("simulate", bench, *words)
        self.assertEqual(code, 2)
        self.assertIn("contact.ring2.model is 'linear'", error)
        linear = torso / "brace.scenario.yaml"
        code, _, error = run_command("simulate", linear, *words)
        self.assertEqual(code, 2)
        self.assertIn("contact.ring1.model is 'linear'", error)

    def test_the_seed_decides_the_noise(self):
        first, again, other = (
            LoadCampaign(self.record(f"n{i}", [1, 2, 3], "--noise-seed", seed))
            for i, seed in enumerate((1, 1, 2))
        )
        lengths = [
            c.runs[0].channels["leg18_length_m"] for c in (first, again, other)
        ]
        np.testing.assert_array_equal(lengths[0], lengths[1])
        # Noise of 5 um, and rounding to 10 um.
        spread = (lengths[0] - lengths[2]).std() / np.sqrt(2.0)
        expected = np.hypot(5e-6, 1e-5 / 12**0.5)
        self.assertAlmostEqual(spread / expected, 1.0, delta=0.25)


class TestStagesOfACampaign(unittest.TestCase):
    def problems(self, stages):
        text = (
            "format: brace-campaign/1\ndevice: brace\nrate_hz: 200\n"
            f"stages: {stages}\nruns:\n- {{file: a.csv, contact: true,"
            " motion: push, split: fit}\n"
        )
        manifest, found = parse_manifest(text.encode())
        errors = [str(p) for p in found if p.severity == "error"]
        return manifest, errors

    def test_only_neighbours_from_below_pass(self):
        for stages in ("[1]", "[1, 2]", "[2, 3]", "[1, 2, 3]"):
            manifest, errors = self.problems(stages)
            self.assertEqual(errors, [])
            self.assertEqual(list(manifest.stages), eval(stages))
        for stages in ("[]", "[1, 3]", "[2, 1]", "[0]", "[4]", "2", "[true]"):
            with self.subTest(stages=stages):
                (error,) = self.problems(stages)[1]
                self.assertIn("stages must be neighbours of 1, 2, 3", error)


if __name__ == "__main__":
    unittest.main()

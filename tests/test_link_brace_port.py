"""A whole brace behind a port: recordings, deployment, refusals."""

import contextlib
import csv
import math
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import LinkError
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.motions.parts import ramp
from brace_drake.link.device.limits_file import LoadLimits
from brace_drake.link.emulator.brace_plant import BracePlant
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.operation.rows import columns_of
from brace_drake.link.operation.station import CheckDevice
from brace_drake.link.protocol.words import DeviceState
from brace_drake.model.simulate import RecordBrace, SimulateBrace
from brace_drake.recording import CheckCampaign, LoadCampaign
from brace_drake.recording.write import format_table
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.load import SaveScenario
from tests.commands import run_command
from tests.emulated_devices import PATIENT_LIMITS, emulated, wait_for

RINGS = (1, 2, 3)


def push(depth, ring=2):
    """A quick push as a reference's run."""
    time = np.arange(120) / 200.0
    samples = ramp(time, 0.05, 0.25, depth)
    run = SafeMotion("push", "", True, "push", time, samples).run
    channels = {
        name.replace("ring2", f"ring{ring}"): values
        for name, values in run.channels.items()
    }
    return replace(run, channels=channels)


@contextlib.contextmanager
def emulated_brace(scenario):
    limits = LoadLimits(None, scenario.stages)
    make = "tests.emulated_devices.BenchPlant"
    with (
        mock.patch(make, lambda scenario, uses: BracePlant(scenario, uses)),
        emulated(scenario=scenario, limits=limits) as device,
    ):
        yield device


class TestRates(unittest.TestCase):
    def test_a_rate_that_is_none_or_another_is_refused_before_any_other_use(
        self,
    ):
        scenario = BraceScenario()
        hello = describe_device(scenario)
        own = hello.rate_hz
        for rate in (math.nan, math.inf, -math.inf, 0.0, -own, 2.0 * own):
            said = hello._replace(rate_hz=rate)
            told = mock.Mock(path="port", hello=said)
            with self.subTest(rate=rate):
                with self.assertRaisesRegex(LinkError, "ticks at .* the scen"):
                    CheckDevice(told, scenario)


class TestPort(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.scenario = BraceScenario()
        cls.file = cls.folder / "brace.scenario.yaml"
        SaveScenario(cls.scenario, cls.file)
        # A machine that tests share is late at times.
        cls.limits = cls.folder / "limits.yaml"
        cls.limits.write_text(PATIENT_LIMITS)

    def write_reference(self, run):
        file = self.folder / f"{run.name}.csv"
        file.write_text(format_table(run))
        return file

    def options(self, device, *more):
        return (
            "--port", device.terminal.path, "--limits", self.limits, *more,
        )  # fmt: skip

    def test_deployed_it_tracks_as_the_simulation_does(self):
        reference = push(-0.006)
        out = self.folder / "out"
        with (
            emulated_brace(self.scenario) as device,
            # Whether it keeps its time is another test's matter.
            mock.patch("brace_drake.cli.machine.deploy._DRY_SECONDS", 0.1),
            mock.patch("brace_drake.link.operation.deploy.check_dry_run"),
        ):
            status, _, errors = run_command(
                "deploy", "--scenario", self.file, "--controller", "pic",
                "--motion", self.write_reference(reference), "--countdown", 0,
                "--out", out, *self.options(device),
            )  # fmt: skip
            self.assertEqual(status, 0, errors)
            self.assertTrue(
                wait_for(lambda: device.firmware.state != DeviceState.ARMED)
            )
        with open(out / "ticks.csv", newline="") as text:
            rows = list(csv.DictReader(text))
        log = SimulateBrace(self.scenario, reference)
        for i, ring in enumerate(RINGS):
            y, y_d = (
                np.array([float(r[f"ring{ring}_y{n}"]) for r in rows[::5]])
                for n in ("_m", "_desired_m")
            )
            N = min(len(y), len(log.X))
            simulated = log.X[:N, i, 1]
            expected = np.sqrt(np.mean((y_d[:N] - simulated) ** 2))
            found = np.sqrt(np.mean((y_d[:N] - y[:N]) ** 2))
            with self.subTest(ring=ring):
                self.assertGreater(expected, 2e-4)
                self.assertAlmostEqual(found / expected, 1.0, delta=0.1)
                away = np.sqrt(np.mean((y[:N] - simulated) ** 2))
                self.assertLess(away, 0.1 * expected)
        self.assertIn("leg18_length_m", rows[0])

    def test_a_recording_is_a_campaign_with_the_columns_of_a_simulation(self):
        out = self.folder / "campaign"
        reference = push(-0.003, ring=3)
        with emulated_brace(self.scenario) as device:
            with mock.patch("brace_drake.link.operation.recorder.SETTLE", 0.5):
                status, said, errors = run_command(
                    "record", "--scenario", self.file, "--motion",
                    self.write_reference(reference), "--countdown", 0,
                    "--out", out, *self.options(device),
                )  # fmt: skip
        self.assertEqual(status, 0, errors)
        self.assertIn("120 rows", said)
        findings = [f for f in CheckCampaign(out) if f.severity == "error"]
        self.assertEqual(findings, [])
        campaign = LoadCampaign(out)
        self.assertEqual((campaign.device, campaign.stages), ("brace", ()))
        recorded = campaign.runs[0].channels
        simulated = RecordBrace(self.scenario, reference, noise_seed=0).channels
        names = set(simulated) | {"bridged", "command_age_ticks", "latency_us"}
        with open(out / campaign.runs[0].file) as text:
            head = text.readline().strip().split(",")
        self.assertEqual(set(head), names)
        self.assertEqual(tuple(head), columns_of((1, 2, 3)))
        np.testing.assert_allclose(
            recorded["ring3_y_desired_m"],
            simulated["ring3_y_desired_m"],
            atol=1e-8,
        )
        self.assertFalse(recorded["ring2_y_desired_m"].any())
        for name in ("leg13_length_m", "leg1_length_m"):
            np.testing.assert_allclose(
                recorded[name], simulated[name], atol=6e-5
            )

    def test_a_brace_of_another_geometry_or_size_is_refused(self):
        other = BraceScenario()
        other.joints.stage3.upper.radius = 0.172
        files = {"other": other, "two": replace(BraceScenario(), stages=[2, 3])}
        for name, scenario in files.items():
            SaveScenario(scenario, self.folder / f"{name}.scenario.yaml")
        with emulated_brace(self.scenario) as device:
            for name, words in (
                ("other", r"geometry differs: upper\[1[2-7]\]"),
                ("two", "with 18 legs is not a 'brace' with 12"),
            ):
                file = self.folder / f"{name}.scenario.yaml"
                status, _, errors = run_command(
                    "deploy", "--scenario", file, *self.options(device)
                )
                with self.subTest(name=name):
                    self.assertEqual((status, errors.count("\n")), (2, 1))
                    self.assertRegex(errors, words)
            status, _, errors = run_command("deploy", *self.options(device))
            self.assertIn("is not a 'bench stage 2' with 6", errors)
            self.assertEqual(device.firmware.accepted, 0)


class TestRefusals(unittest.TestCase):
    def test_what_a_brace_does_not_take_has_one_line(self):
        brace = Path(__file__).parents[1] / "diagrams" / "brace.scenario.yaml"
        port = ("--port", "/dev/ttyNone7")
        out = ("--out", "/nowhere")
        for words, said in (
            (("deploy", "--controller", "lqr", *port), "tag"),
            (
                ("record", "--motion", "push", "--ring", 4, *out, *port),
                "ring 4",
            ),
            (("emulate", "--subject", "preload_m=1"), "torso and contact"),
        ):
            with self.subTest(words=words):
                status, _, errors = run_command(*words, "--scenario", brace)
                self.assertEqual((status, errors.count("\n")), (2, 1), errors)
                self.assertIn(said, errors)

    def test_a_brace_takes_an_effect_that_is_other_numbers(self):
        brace = Path(__file__).parents[1] / "diagrams" / "brace.scenario.yaml"
        words = ("emulate", "--effect", "ring_mass", "--duration", 0.1)
        status, said, _ = run_command(*words, "--scenario", brace)
        self.assertEqual(status, 0)
        self.assertIn("port: ", said)

    def test_a_bench_has_its_one_ring(self):
        words = ("deploy", "--ring", 1, "--port", "/dev/ttyNone7")
        status, _, errors = run_command(*words)
        self.assertEqual((status, errors.count("\n")), (2, 1), errors)
        self.assertIn("no ring 1", errors)


if __name__ == "__main__":
    unittest.main()

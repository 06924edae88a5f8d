"""Controllers on a device; plans of campaigns."""

import csv
import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.cli.machine.emulate import carry_out
from brace_drake.core.errors import (
    BraceError,
    CampaignError,
    LinkError,
    StoppedError,
)
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.laws.plug_in import MAX_EFFECTS
from brace_drake.link.operation.campaign import (
    STANDARD_PLAN,
    LoadPlan,
    remaining_runs,
)
from brace_drake.link.operation.control import HostControl
from brace_drake.link.operation.deploy import (
    RunController,
    check_dry_run,
    format_log,
)
from brace_drake.link.operation.station import OpenDevice
from brace_drake.link.operation.tally import Spread, Tally
from brace_drake.link.protocol.words import Cause, DeviceState
from tests.commands import run_command
from tests.emulated_devices import (
    PATIENT,
    PATIENT_LIMITS,
    SCENARIO,
    assert_device_stops,
    emulated,
    wait_for,
)


class TestDeploy(unittest.TestCase):
    def test_a_dry_run_never_arms(self):
        with emulated() as device, tempfile.TemporaryDirectory() as folder:
            limits = Path(folder) / "limits.yaml"
            limits.write_text(PATIENT_LIMITS)
            status, out, error = run_command(
                "deploy", "--port", device.terminal.path, "--dry-run",
                "--limits", limits, "--out", Path(folder) / "o",
            )  # fmt: skip
            # On a machine that is busy the dry run may say that it is late.
            if status == 2:
                self.assertIn("not armed: in the dry run", error)
            else:
                timing = json.loads(
                    (Path(folder) / "o" / "timing.json").read_text()
                )
                self.assertGreater(timing["dry_run"]["ticks"], 2000)
                self.assertIn("dry run:", out)
            self.assertEqual(device.firmware.accepted, 0)
            self.assertIn(
                device.firmware.state,
                (DeviceState.DISARMED, DeviceState.HELLO),
            )

    def test_any_law_with_a_tick_can_be_deployed_and_is_supervised(self):
        class Wild(HostControl):
            """Pushes along y without end, as a bad policy would."""

            def Tick(self, readings, desired):
                super().Tick(readings, desired)
                self.ticks = getattr(self, "ticks", 0) + 1
                self.command += (
                    0.004
                    * self.ticks
                    * np.array([1.0, -1.0, 0.1, -0.1, 1.0, -1.0])
                )
                return self.command

        with emulated() as device:
            path = device.terminal.path
            with OpenDevice(path, SCENARIO, PATIENT) as link:
                control = Wild(SCENARIO)
                with self.assertRaises(StoppedError):
                    RunController(
                        link, control, PATIENT, np.zeros((5000, 3)), False
                    )
            self.assertTrue(
                wait_for(lambda: device.firmware.state != DeviceState.ARMED)
            )
            self.assertNotEqual(device.firmware.trip.cause, Cause.WATCHDOG)

    def test_a_law_that_fails_stops_the_device_and_is_told(self):
        class Broken(HostControl):
            ticks = 0

            def Tick(self, readings, desired):
                self.ticks += 1
                if self.ticks > 500:
                    raise BraceError("the law has no answer")
                return super().Tick(readings, desired)

        with emulated() as device:
            with OpenDevice(device.terminal.path, SCENARIO, PATIENT) as link:
                with self.assertRaisesRegex(
                    StoppedError, "host error: the law has no answer"
                ):
                    RunController(
                        link, Broken(SCENARIO), PATIENT, np.zeros((5000, 3)),
                        False,
                    )  # fmt: skip
            assert_device_stops(self, device, Cause.HOST_ERROR)

    def test_a_run_that_is_stopped_leaves_its_ticks_and_the_cause(self):
        class Pressed:
            """Lets the dry run pass, and stops the armed one."""

            is_terminal = False

            def __enter__(self):
                return self

            def __exit__(self, *_):
                pass

            def pressed(self):
                return device.firmware.accepted > 1500

        with (
            emulated() as device,
            tempfile.TemporaryDirectory() as folder,
            mock.patch("brace_drake.link.operation.console.ReadKeys", Pressed),
            # A machine that tests share is late at times.
            mock.patch("brace_drake.link.operation.deploy.check_dry_run"),
        ):
            limits, out = Path(folder) / "limits.yaml", Path(folder) / "o"
            limits.write_text(PATIENT_LIMITS)
            status, _, error = run_command(
                "deploy", "--port", device.terminal.path, "--countdown", 0,
                "--motion", "push", "--limits", limits, "--out", out,
            )  # fmt: skip
            self.assertEqual(status, 2)
            self.assertIn("stop key", error)
            with open(out / "ticks.csv", newline="") as text:
                ticks = [int(row["tick"]) for row in csv.DictReader(text)]
            timing = json.loads((out / "timing.json").read_text())
            assert_device_stops(self, device, Cause.STOP_KEY)
        # A second to settle, then each tick until the key.
        self.assertEqual(ticks, list(range(len(ticks))))
        self.assertGreater(len(ticks), 500)
        self.assertLess(len(ticks), 12000)
        self.assertNotIn("stopped", timing["dry_run"])
        self.assertEqual(
            timing["armed"]["stopped"],
            f"stopped after {len(ticks)} ticks: stop key",
        )
        self.assertIn(timing["armed"]["stopped"], error)

    def test_a_run_is_logged_tick_by_tick(self):
        with emulated() as device:
            path = device.terminal.path
            with OpenDevice(path, SCENARIO, PATIENT) as link:
                kept = []
                session = RunController(
                    link, HostControl(SCENARIO), PATIENT, np.zeros((300, 3)),
                    False, keep=lambda _, rows, __: kept.extend(rows),
                )  # fmt: skip
            rows = format_log(kept, (2,)).splitlines()
            self.assertEqual(len(rows), 301)
            timing = session.tally.describe()
            # A second to settle, then each of the 300.
            self.assertGreaterEqual(timing["ticks"], 1300)
            self.assertEqual(len(timing["latency_us"]), 3)
            self.assertIn("ticks at", str(session.tally))

    def test_a_dry_run_that_was_late_is_refused(self):
        def tally(ticks, slow):
            seen = Tally(ticks=ticks)
            for late in [1e-4] * 97 + [slow] * 3:
                seen.latencies.Add(late)
                seen.periods.Add(1e-3)
            return seen

        check_dry_run(tally(2000, 9e-4))
        with self.assertRaisesRegex(StoppedError, "not armed"):
            check_dry_run(tally(2000, 1.1e-3))
        with self.assertRaisesRegex(StoppedError, "50 ticks only"):
            check_dry_run(tally(50, 1e-4))


class TestSpread(unittest.TestCase):
    def test_percentiles_are_those_of_the_values_to_one_per_cent(self):
        draw, spread = np.random.default_rng(3), Spread()
        values = np.exp(draw.normal(np.log(2e-4), 1.0, 20_000))
        for value in values:
            spread.Add(value)
        expected = np.percentile(values, (50.0, 99.0, 99.9))
        np.testing.assert_allclose(spread.percentiles(), expected, rtol=0.02)
        self.assertAlmostEqual(spread.mean / values.mean(), 1.0)
        self.assertEqual(spread.largest, values.max())

    def test_what_is_out_of_its_bins_is_counted_at_their_ends(self):
        spread = Spread()
        self.assertEqual(spread.percentiles(), [])
        for value in (0.0, 0.0, 1e9):
            spread.Add(value)
        low, high = spread.percentiles((50.0, 100.0))
        self.assertLess(low, 2e-6)
        self.assertGreater(high, 100.0)


class TestEmulatorsWords(unittest.TestCase):
    def test_each_line_of_the_help_is_obeyed(self):
        with emulated() as device:
            for line in (
                "torso off", "rest",
                "estop on", "estop off", "drive on", "drive off",
                "stuck 3", "frozen 3", "free", "to-host drop 0.01",
                "to-device delay 0.005", "noise 500", "",
            ):  # fmt: skip
                carry_out(device, line)
            self.assertEqual(device.faults.to_host.drop, 0.01)
            self.assertEqual(device.faults.to_device.delay, 0.005)
            for line in ("jump", "stuck 7", "stuck x", "to-host drop 2"):
                with self.assertRaises(LinkError) as caught:
                    carry_out(device, line)
                self.assertNotIn("\n", str(caught.exception))

    def test_more_effects_at_once_than_a_plant_carries_are_refused(self):
        def before_any_begins(device):
            for number in range(1, MAX_EFFECTS + 1):
                carry_out(device, f"effect force_bias:force_bias_N=0.{number}")
            with self.assertRaisesRegex(LinkError, f"most {MAX_EFFECTS}"):
                carry_out(device, "effect force_bias:force_bias_N=0.9")

        with emulated(before_any_begins) as device:
            with self.assertRaises(LinkError):
                carry_out(device, "effect force_bias:force_bias_N=0.9")


class TestPlan(unittest.TestCase):
    def test_the_standard_plan_has_what_a_diagnosis_needs(self):
        for run in STANDARD_PLAN:
            MakeMotion(run.motion)
        splits = [r.split for r in STANDARD_PLAN]
        self.assertGreaterEqual(splits.count("validation"), 3)
        self.assertTrue(any(r.repeat for r in STANDARD_PLAN))
        contact = [MakeMotion(r.motion).contact for r in STANDARD_PLAN]
        # The torso comes once.
        self.assertEqual(contact, sorted(contact))

    def test_a_campaign_goes_on_where_it_stopped(self):
        done = [
            {"file": "free_multisine.csv", "split": "fit", "complete": True},
            {"file": "push.csv", "split": "fit", "complete": True},
            {"file": "stairs.csv", "split": "fit", "complete": False},
        ]
        left = [run.motion for _, run in remaining_runs(STANDARD_PLAN, done)]
        self.assertNotIn("free_multisine", left)
        self.assertEqual(left.count("push"), 1)
        self.assertIn("stairs", left)
        done.append({"file": "push_2.csv", "split": "fit"})
        left = [run.motion for _, run in remaining_runs(STANDARD_PLAN, done)]
        self.assertNotIn("push", left)
        self.assertEqual(len(left), len(STANDARD_PLAN) - 3)

    def test_bad_plans_are_told_in_one_line(self):
        head = "format: brace-plan/1\n"
        cases = (
            ("runs: []", "format must be"),
            (head, "runs must be a list"),
            (head + "runs: [{}]", "run 1 has no motion"),
            (head + "runs: [{motion: pusch}]", "did you mean push"),
            (head + "runs: [{motion: push, spilt: fit}]", "did you mean split"),
            (head + "runs: [{motion: push, split: test}]", "split is 'test'"),
            (head + "runs: [{motion: push, repeat: 2}]", "repeat is 2"),
        )
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "plan.yaml"
            for text, words in cases:
                path.write_text(text)
                with self.assertRaises(CampaignError) as caught:
                    LoadPlan(path)
                self.assertIn(words, str(caught.exception))
            path.write_text(head + "runs: [{motion: push, repeat: true}]")
            self.assertTrue(LoadPlan(path)[0].repeat)


if __name__ == "__main__":
    unittest.main()

"""Commands with a device, from the first word to the last."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import unittest
import urllib.request
from pathlib import Path
from unittest import mock

import numpy as np
import yaml

from brace_drake.devices.motions.library import MakeMotion, SafeMotion
from brace_drake.devices.motions.parts import ramp
from brace_drake.devices.motions.reference import format_reference
from brace_drake.effects.registry import find_effect
from brace_drake.learning.policy import SavePolicy
from brace_drake.link.protocol.words import Cause, DeviceState
from tests.commands import run_command
from tests.emulated_devices import (
    PATIENT_LIMITS,
    assert_device_stops,
    emulated,
    wait_for,
)
from tests.learning_tasks import random_policy, short_task

ROOT = Path(__file__).resolve().parents[1]


def make_still(seconds):
    """A motion that holds at rest."""
    time = np.arange(round(200 * seconds)) / 200.0
    return SafeMotion("still", "", True, "hold", time, np.zeros((len(time), 3)))


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        # A machine that tests share is late at times.
        self.limits = self.folder / "limits.yaml"
        self.limits.write_text(PATIENT_LIMITS)


class TestTwin(Folder):
    def setUp(self):
        super().setUp()
        self.motion = self.folder / "still.csv"
        self.motion.write_text(format_reference(make_still(1.2).run))
        card = find_effect("force_bias")
        # The ring yields to a force that is not there, and takes the torso on.
        self.bias = (card, card.vector({"force_bias_N": 0.8}))

    @contextlib.contextmanager
    def twin(self, device, *more):
        """The command in a process of its own, while it runs."""
        process = subprocess.Popen(
            [sys.executable, "-m", "brace_drake.cli.main", "twin",
             "--port", device.terminal.path, "--motion", str(self.motion),
             "--limits", str(self.limits), "--countdown", "0", *more],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        try:
            yield process
        finally:
            process.kill()
            process.communicate()

    def watch(self, process):
        """What the page is told until the command ends."""
        url = process.stdout.readline().removeprefix("page: ").strip()
        self.assertTrue(url.startswith("http://127.0.0.1:"), url)
        told = []
        with (
            contextlib.suppress(OSError),
            urllib.request.urlopen(url + "events", timeout=300) as stream,
        ):
            for line in stream:
                if line.startswith(b"data: {"):
                    told.append(json.loads(line.removeprefix(b"data: ")))
        return told

    def test_a_device_with_an_effect_shows_gap_and_alarm_to_the_end(self):
        with (
            emulated(uses=(self.bias,)) as device,
            self.twin(device) as process,
        ):
            told = self.watch(process)
            said, errors = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 0, errors)
            self.assertIn("alarm: ring2_force_y_N leaves its band\n", said)
            self.assertRegex(said, r"contact: \d+ N/m, \d+ N s/m\n")
            self.assertRegex(said, r"largest gap: leg\d_length_m, \d")
            self.assertIn("ring2_force_y_N", told[-1]["alarms"])
            ratio = told[-1]["ratio"]
            self.assertGreater(ratio["ring2_force_y_N"], told[-1]["band"])
            self.assertLess(ratio["ring2_force_z_N"], told[-1]["band"])
            self.assertTrue(
                wait_for(lambda: device.firmware.state != DeviceState.ARMED)
            )
            self.assertEqual(device.firmware.trip.cause, Cause.NONE)

    def test_an_alarm_stops_the_device_where_it_is_asked_to(self):
        with (
            emulated(uses=(self.bias,)) as device,
            self.twin(device, "--stop-at-alarm") as process,
        ):
            _, errors = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 2)
            self.assertRegex(errors, r"still: stopped: alarm in leg\d_length_m")
            self.assertNotIn("Traceback", errors)
            assert_device_stops(self, device, Cause.HOST_STOP)

    def test_a_live_view_that_dies_does_not_end_the_motion(self):
        with emulated() as device, self.twin(device) as process:
            self.assertIn("page: ", process.stdout.readline())
            tasks = Path(f"/proc/{process.pid}/task").glob("*/children")
            views = [int(n) for task in tasks for n in task.read_text().split()]
            self.assertEqual(len(views), 1)
            os.kill(views[0], signal.SIGABRT)
            _, errors = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 0, errors)
            self.assertEqual(device.firmware.trip.cause, Cause.NONE)

    def test_a_device_like_the_twin_raises_none(self):
        with emulated() as device, self.twin(device) as process:
            said, errors = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 0, errors)
            self.assertNotIn("alarm", said)


class TestPlans(Folder):
    def run_plan(self, *words):
        def short(name):
            motion = MakeMotion(name)
            time = np.arange(100) / 200.0
            samples = ramp(time, 0.1, 0.3, -0.002)
            return SafeMotion(
                name, "", motion.contact, motion.kind, time, samples
            )

        with (
            mock.patch("sys.stdin", io.StringIO("\n\n\n")),
            mock.patch("brace_drake.link.operation.campaign.MakeMotion", short),
        ):
            return run_command(*words)

    def test_record_takes_a_plan_and_campaign_goes_on_with_it(self):
        plan, out = self.folder / "plan.yaml", self.folder / "c"
        head = "format: brace-plan/1\nruns:\n- {motion: free_reversal}\n"
        push = "- {motion: push, split: validation}\n"
        plan.write_text(head + push)
        with emulated() as device:
            options = ("--port", device.terminal.path, "--limits", self.limits)
            options += ("--out", out, "--countdown", 0)
            status, said, errors = self.run_plan(
                "record", "--motion", plan, *options
            )
            self.assertEqual(status, 0, errors)
            self.assertIn("run 2 of 2: push (validation)", said)
            asked = ["Take the torso out", "Put the torso in"]
            self.assertEqual([a for a in asked if a in said], asked)
            plan.write_text(head + push + "- {motion: push, repeat: true}\n")
            status, said, errors = self.run_plan(
                "campaign", "--plan", plan, *options
            )
            self.assertEqual(status, 0, errors)
            self.assertIn("1 runs recorded", said)
            self.assertNotIn("run 2", said)
        runs = yaml.safe_load((out / "campaign.yaml").read_text())["runs"]
        found = [(r["file"], r["contact"], r["split"]) for r in runs]
        self.assertEqual(
            found,
            [
                ("free_reversal.csv", False, "fit"),
                ("push.csv", True, "validation"),
                ("push_2.csv", True, "fit"),
            ],
        )
        self.assertTrue(all(r["complete"] for r in runs))

    def test_no_command_moves_a_device_further_than_any_may(self):
        time = np.arange(600) / 200.0
        far = SafeMotion(
            "far", "", True, "push", time, ramp(time, 0.5, 1.0, -0.013)
        )
        file = self.folder / "far.csv"
        file.write_text(format_reference(far.run))
        policy = self.folder / "policy.npz"
        way = np.array([0.0, -0.013, 0.0, 0.0, 0.0, 0.0])
        task = short_task(40, motion_time=2.0, displacement=way)
        SavePolicy(random_policy(task), policy)
        options = ("--port", "/dev/null", "--limits", self.limits)
        for words in (
            ("record", "--motion", file, "--out", self.folder / "c"),
            ("deploy", "--motion", file),
            ("deploy", "--policy", policy),
            ("deploy", "--policy", policy, "--motion", file),
            ("twin", "--motion", file),
        ):
            with self.subTest(words=words):
                status, _, errors = self.run_plan(*words, *options)
                self.assertEqual((status, errors.count("\n")), (2, 1), errors)
                self.assertRegex(errors, r"reaches 13.0 mm, allowed 12 mm")

    def test_results_lie_beside_a_folder_that_ends_in_a_slash(self):
        with (
            mock.patch("brace_drake.cli.machine.campaign.OpenRecorder"),
            mock.patch("brace_drake.link.operation.campaign.RecordRuns"),
        ):
            for folder in ("monday", "monday/"):
                options = ("--port", "/dev/null", "--out", folder)
                status, said, errors = self.run_plan("campaign", *options)
                self.assertEqual(status, 0, errors)
                last = said.splitlines()[-1]
                self.assertTrue(last.endswith(" --out monday-results"), last)

    def test_a_split_beside_a_plan_and_a_bad_plan_have_one_line(self):
        plan = self.folder / "plan.yaml"
        plan.write_text("format: brace-plan/1\nruns: [{motion: pusch}]\n")
        options = ("--port", "/dev/null", "--out", self.folder / "c")
        for more, words in (
            ((), "did you mean push"),
            (("--split", "fit"), "each run of"),
        ):
            status, _, errors = self.run_plan(
                "record", "--motion", plan, *more, *options
            )
            self.assertEqual((status, errors.count("\n")), (2, 1), errors)
            self.assertIn(words, errors)


if __name__ == "__main__":
    unittest.main()

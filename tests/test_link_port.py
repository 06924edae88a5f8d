"""A device on a pseudo-terminal: strangers, disconnects, kills, recordings."""

import itertools
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tty
import unittest
from multiprocessing import get_context
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import LimitsError, LinkError, StoppedError
from brace_drake.link.device.firmware import Firmware
from brace_drake.link.host.link import Link
from brace_drake.link.host.ports import OpenPort
from brace_drake.link.operation.journal import Journal
from brace_drake.link.operation.recorder import SETTLE, Recorder
from brace_drake.link.operation.rows import columns_of
from brace_drake.link.protocol.codec import Decoder, make_codec
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.link.protocol.sequence import SequenceWatch
from brace_drake.link.protocol.words import Cause, DeviceState
from brace_drake.recording import CheckCampaign, LoadCampaign
from brace_drake.scenario.brace import BenchScenario
from tests.commands import run_command
from tests.emulated_devices import (
    PATIENT,
    PATIENT_LIMITS,
    SCENARIO,
    NoKeys,
    assert_device_stops,
    emulated,
    open_recorder,
    short_push,
    wait_for,
)

ROOT = Path(__file__).resolve().parents[1]


class Pty:
    """A pseudo-terminal whose other end says what it is told."""

    def __enter__(self):
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        return self

    def __exit__(self, *_):
        os.close(self.master)
        os.close(self._slave)


class TestFullLine(unittest.TestCase):
    def test_a_line_that_is_not_read_for_a_while_loses_frames_and_goes_on(self):
        beat = {"echo_us": 0}
        with Pty() as pty, Link(pty.path) as link:
            begun = time.monotonic()
            while time.monotonic() - begun < 1.0:
                link.Send("HEARTBEAT", beat)
            self.assertIsNone(link.error)
            while select.select([pty.master], [], [], 0.0)[0]:
                os.read(pty.master, 65536)
            sent = link.Send("HEARTBEAT", beat)
            decoder = Decoder(make_codec(1))
            heard = decoder.feed(os.read(pty.master, 65536))
            self.assertEqual([p.sequence for p in heard], [sent])


class TestPorts(unittest.TestCase):
    def assert_refused(self, words, path="/dev/null"):
        with self.assertRaises(LinkError) as caught:
            OpenPort(path)
        self.assertIn(words, str(caught.exception))
        self.assertIn(path, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))

    def test_each_way_to_fail_has_its_line(self):
        self.assert_refused("no such port", "/dev/ttyNone7")
        with tempfile.NamedTemporaryFile() as file:
            self.assert_refused("not a serial port", file.name)
        denied = OSError(13, "could not open port")
        with mock.patch("serial.serial_for_url", side_effect=denied):
            self.assert_refused("no permission")

    def test_a_port_in_use_is_said_to_be(self):
        with Pty() as pty:
            first = OpenPort(pty.path)
            self.assert_refused("in use", pty.path)
            first.close()
            OpenPort(pty.path).close()

    def test_the_command_line_has_one_line_and_status_two(self):
        status, _, errors = run_command(
            "record", "--port", "/dev/ttyNone7", "--motion", "push",
            "--out", "/nowhere",
        )  # fmt: skip
        self.assertEqual(status, 2)
        self.assertEqual(errors.count("\n"), 1)
        self.assertIn("no such port", errors)


class TestStrangers(unittest.TestCase):
    def test_silence_and_noise_are_told_apart(self):
        for noise, words in (
            (b"", "no answer to hello"),
            (b"\x17U-Boot 2024.01\r\n\0login: \0", "no message among them"),
        ):
            with Pty() as pty:
                link = Link(pty.path)
                os.write(pty.master, noise)
                with self.assertRaisesRegex(LinkError, words):
                    link.Connect(timeout=0.5)
                link.Close()

    def test_a_device_of_another_geometry_is_refused_by_place(self):
        other = BenchScenario(time_step=5e-4)
        other.joints.stage2.upper.radius = 0.182
        with emulated() as device, tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(LinkError, r"geometry.*upper\["):
                Recorder(device.terminal.path, other, DEFAULT, folder)

    def test_wider_limits_are_refused_by_name(self):
        with emulated() as device, tempfile.TemporaryDirectory() as folder:
            wide = DEFAULT._replace(pad_force=60.0)
            with self.assertRaisesRegex(LimitsError, "pad_force is 60"):
                Recorder(device.terminal.path, SCENARIO, wide, folder)
            self.assertEqual(device.firmware.state, DeviceState.HELLO)

    def test_an_answer_to_somebody_else_is_waited_out(self):
        wrong, asked = 3, []
        answer = Firmware._on_hello_request

        def answer_others_first(firmware, packet, now):
            asked.append(packet.values.nonce)
            answers, reason = answer(firmware, packet, now)
            if len(asked) <= wrong:
                answers[0][1]["nonce"] ^= 1
            return answers, reason

        with (
            mock.patch.object(
                Firmware, "_on_hello_request", answer_others_first
            ),
            emulated() as device,
            Link(device.terminal.path) as link,
        ):
            link.Connect(10.0)
            self.assertEqual(link.hello.nonce, asked[0])
        # One more for each, but where this machine was late.
        self.assertGreater(len(asked), wrong)
        self.assertLess(len(asked), 2 * wrong + 2)

    def test_noise_before_hello_does_not_keep_them_apart(self):
        def prepare(device):
            device.faults.noise_before_hello = 600

        with emulated(prepare) as device:
            with Link(device.terminal.path) as link:
                link.Connect(20.0)
                self.assertEqual(link.hello.identity, "test-1")
                link.Agree(DEFAULT)
                self.assertTrue(wait_for(lambda: link.counts.states > 50))


def rows_on_disk(path):
    """Rows of a recording so far: each ends its line, as the header does."""
    return path.read_bytes().count(b"\n") - 1 if path.exists() else 0


# A recording waits for torso and pads to come to rest; tests need not.
_QUICK = mock.patch("brace_drake.link.operation.recorder.SETTLE", 0.5)


@_QUICK
class TestDisconnect(unittest.TestCase):
    def pull(self, device, out):
        """Unplugs when more than 50 rows of the second run are on the disk."""
        wait_for(lambda: rows_on_disk(out / "push_2.csv") > 50, 300.0)
        device.plug(False)

    def test_unplugging_ends_the_motion_and_keeps_what_was_recorded(self):
        with (
            emulated(patience=5.0) as device,
            tempfile.TemporaryDirectory() as folder,
        ):
            out = Path(folder) / "c"
            with open_recorder(device, out) as recorder:
                recorder.Record(short_push(), "fit", 0, NoKeys())
                pull = threading.Thread(target=self.pull, args=(device, out))
                pull.start()
                with self.assertRaises(StoppedError) as caught:
                    recorder.Record(short_push(20.0), "fit", 0, NoKeys())
                self.assertRegex(str(caught.exception), "gone|disconnected")
                pull.join()
            campaign = LoadCampaign(out)
            whole, cut = campaign.runs
            self.assertEqual(len(whole.time_s), 200)
            self.assertGreater(len(cut.time_s), 50)
            assert_device_stops(self, device, Cause.WATCHDOG)


@_QUICK
class TestRecording(unittest.TestCase):
    def test_a_recording_shows_the_motion_and_who_made_it(self):
        with emulated() as device, tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "c"
            with open_recorder(device, out) as recorder:
                recorder.Record(short_push(), "fit", 0, NoKeys())
                recorder.Record(short_push(), "fit", 0, NoKeys())
            text = (out / "campaign.yaml").read_text()
            for words in (
                "identity: test-1",
                "firmware: emulated 1.0",
                "settled_s: 0.5",
            ):
                self.assertIn(words, text)
            errors = [p for p in CheckCampaign(out) if p.severity == "error"]
            self.assertEqual(errors, [])
            first, second = LoadCampaign(out).runs
            self.assertEqual(second.repeat_of, "push.csv")
            for run in (first, second):
                force = run.channels["ring2_force_y_N"]
                self.assertLess(force[-20:].mean(), -3.0)
                steps = np.diff(run.time_s)
                np.testing.assert_allclose(steps, 0.005, atol=1e-9)

    def test_the_stop_key_stops_and_a_stop_must_be_cleared(self):
        class Pressed(NoKeys):
            def pressed(self):
                self.calls = getattr(self, "calls", 0) + 1
                return self.calls > 60

        with emulated() as device, tempfile.TemporaryDirectory() as folder:
            path = device.terminal.path
            with Recorder(path, SCENARIO, PATIENT, folder) as recorder:
                with self.assertRaisesRegex(StoppedError, "stop key"):
                    recorder.Record(short_push(20.0), "fit", 0, Pressed())
            assert_device_stops(self, device, Cause.STOP_KEY)
            with self.assertRaisesRegex(LinkError, "stop key.*--clear"):
                Recorder(path, SCENARIO, PATIENT, folder)
            Recorder(path, SCENARIO, PATIENT, folder, clear=True).link.Close()
            self.assertEqual(device.firmware.state, DeviceState.DISARMED)


_HEAD = {"device": "bench stage 2", "rate_hz": 200.0}


def write_without_end(folder, ready):
    """Rows of a push, that no check finds odd, until the process is killed."""
    run = Journal(folder, _HEAD).NewRun(
        "push", columns_of((2,)), True, "push", "fit"
    )
    ready.set()
    for i in itertools.count():
        row = [i / 200.0]
        for k in range(6):
            row += [2.0 + 0.01 * ((i * 7 + k) % 13)]
            row += [0.141 + 1e-5 * ((i + k) % 3)]
        row += [0.01 * (i % 5), 0.02 * (i % 7), 0.03 * (i % 3)]
        row += [1e-6 * i, 2e-4 + 1e-9 * i, 1e-9 * i, 1e-6 * i]
        row += [1e-6 * (i % 5), 1e-6 * (i % 3), 1e-6 * (i % 7), 0, 0, 100]
        run.Append(row)
        run.Flush(now=i % 3 == 0)


class TestKill(unittest.TestCase):
    def test_a_journal_killed_at_any_moment_holds_whole_rows_only(self):
        draw, context = np.random.default_rng(5), get_context("fork")
        for _ in range(5):
            with tempfile.TemporaryDirectory() as folder:
                ready = context.Event()
                child = context.Process(
                    target=write_without_end, args=(folder, ready)
                )
                child.start()
                ready.wait()
                manifest = Path(folder) / "campaign.yaml"
                self.assertTrue(wait_for(manifest.exists))
                time.sleep(draw.uniform(0.05, 0.3))
                child.kill()
                child.join()
                problems = CheckCampaign(folder)
                errors = [p for p in problems if p.severity == "error"]
                self.assertEqual(errors, [])
                data = (Path(folder) / "push.csv").read_bytes()
                self.assertEqual(data[-1:], b"\n")

    def test_rows_never_cross_a_page(self):
        with tempfile.TemporaryDirectory() as folder:
            journal = Journal(folder, _HEAD)
            columns = columns_of((2,))
            run = journal.NewRun("push", columns, True, "push", "fit")
            for i in range(40):
                run.Append([0.005 * i, *[-123.4] * (len(columns) - 1)])
            run.Close(True, {})
            data = (Path(folder) / "push.csv").read_bytes()
        ends = [i for i, byte in enumerate(data) if byte == 10]
        begins = [0, *[e + 1 for e in ends[:-1]]]
        for begin, end in list(zip(begins, ends, strict=True))[1:]:
            self.assertEqual(begin // 4096, end // 4096)

    def test_record_killed_leaves_a_campaign_valid_to_its_last_second(self):
        with (
            emulated(patience=5.0) as device,
            tempfile.TemporaryDirectory() as folder,
        ):
            out = Path(folder) / "c"
            limits = Path(folder) / "limits.yaml"
            limits.write_text(PATIENT_LIMITS)
            record = subprocess.Popen(
                [sys.executable, "-m", "brace_drake.cli.main", "record",
                 "--port", device.terminal.path, "--motion", "push",
                 "--out", str(out), "--countdown", "0",
                 "--limits", str(limits)],
                cwd=ROOT,
                stderr=subprocess.DEVNULL,
            )  # fmt: skip
            self.addCleanup(record.wait)
            self.addCleanup(record.kill)
            file = out / "push.csv"
            self.assertTrue(wait_for(lambda: rows_on_disk(file) > 20, 300.0))
            # Longer than what may be lost.
            time.sleep(1.3)
            os.kill(record.pid, signal.SIGKILL)
            record.wait()
            (run,) = LoadCampaign(out).runs
            self.assertGreater(len(run.time_s), 20)
            assert_device_stops(self, device, Cause.WATCHDOG)
            # The device's time: this machine's may have stood still for both.
            moved = device.firmware.accepted - round(1e3 * SETTLE)
            self.assertLess(moved - 5 * len(run.time_s), 1000)


class TestCounting(unittest.TestCase):
    def test_lost_repeated_and_late_are_told_apart_over_the_wrap(self):
        watch = SequenceWatch()
        taken = [
            watch.take(n & 0xFFFF)
            for n in (65533, 65534, 65534, 65537, 65536, 65538)
        ]
        self.assertEqual(taken, [0, 0, None, 2, None, 0])
        self.assertEqual((watch.lost, watch.repeated, watch.late), (2, 1, 1))

    def test_one_number_far_ahead_costs_nothing_behind_it(self):
        watch = SequenceWatch()
        numbers = (1, 2, 20000, 3, 20001, 4, 500, 501, 502)
        taken = [watch.take(n) for n in numbers]
        # After a real gap the first message behind it is missing too.
        self.assertEqual(taken, [0, 0, None, 0, None, 0, None, 496, 0])
        self.assertEqual((watch.lost, watch.late), (496, 0))


class TestTools(unittest.TestCase):
    def run_tool(self, *words):
        done = subprocess.run(
            [sys.executable, *words],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_no_damage_is_acted_upon_and_no_whole_frame_is_lost(self):
        for way in ("to-device", "to-host"):
            said = self.run_tool(
                "tools/fuzz_link.py", "--frames", "5000", "--way", way
            )
            self.assertRegex(said, r"wrong +0\n")
            # What came through was looked at, and not all of it was refused.
            self.assertRegex(said, r"(accepted|commands) +[5-9]\d{3}\n")

    def test_the_watchdog_stops_after_each_kill_of_the_host(self):
        said = self.run_tool("tools/kill_host.py", "--kills", "3")
        self.assertIn("3 of 3", said)

    def test_nothing_is_lost_without_a_count_and_no_memory_grows(self):
        said = self.run_tool(
            "tools/soak_link.py", "--seconds", "3", "--host-paced",
            "--stale", "5",
        )  # fmt: skip
        self.assertRegex(said, r"missing unseen +0\n")


if __name__ == "__main__":
    unittest.main()

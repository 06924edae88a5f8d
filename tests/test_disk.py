"""Disks that are full or read-only, processes killed, two at one folder."""

import ast
import contextlib
import io
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from datetime import UTC, datetime, timedelta
from pathlib import Path
from unittest import mock

import numba
import numpy as np

from brace_drake import laws
from brace_drake.cli.main import main
from brace_drake.core.errors import BraceError, OutputError
from brace_drake.core.output import (
    HoldFolder,
    MakeFolder,
    ReleaseFolder,
    ReleaseFolders,
    WriteBytes,
    WriteText,
)
from brace_drake.core.resources import policy_path
from brace_drake.link.operation.journal import Journal
from brace_drake.link.operation.recorder import Recorder
from brace_drake.link.operation.rows import columns_of
from brace_drake.link.protocol.words import Cause
from brace_drake.recording import CheckCampaign, LoadCampaign, WriteCampaign
from brace_drake.report import WriteReport
from brace_drake.report import page as report_page
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import SaveScenario
from tests.emulated_devices import (
    PATIENT,
    NoKeys,
    assert_device_stops,
    emulated,
    short_push,
)
from tests.emulated_devices import SCENARIO as BENCH
from tests.shared_data import EXAMPLE
from tests.test_campaign_read import make_campaign

ROOT = Path(__file__).resolve().parents[1]
DEVICE = "bench stage 2"
HEAD = {"device": DEVICE, "rate_hz": 200.0, "subject": "x", "recorded": {}}


@contextlib.contextmanager
def room_for(size):
    """No file of this process may grow beyond a size, as on a full disk.

    Both take a part of a write, and refuse the next.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextlib.contextmanager
def without_rights():
    """Root obeys no permissions; nobody does."""
    is_root = os.geteuid() == 0
    if is_root:
        os.seteuid(65534)
    try:
        yield
    finally:
        if is_root:
            os.seteuid(0)


def start(code, *words):
    """A Python process that knows the package, with pipes."""
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, words)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.addCleanup(ReleaseFolders)

    def names(self):
        return sorted(os.listdir(self.folder))

    def run_main(self, *words):
        """Status and what was said of a command."""
        said = tempfile.TemporaryFile("w+")
        with said, contextlib.redirect_stderr(said):
            with contextlib.redirect_stdout(io.StringIO()):
                status = main([str(word) for word in words])
            said.seek(0)
            return status, said.read()

    def start(self, code, *words):
        process = start(code, *words)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stdin.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process


class TestFullDisk(Folder):
    def test_a_command_that_is_refused_leaves_no_folder(self):
        out = self.folder / "new" / "results"
        status, said = self.run_main(
            "diagnose", EXAMPLE, "--scenario", "none.yaml", "--out", out
        )
        self.assertEqual(status, 2, said)
        self.assertEqual(self.names(), [])

    def test_no_pipe_and_no_link_gives_its_place_to_a_result(self):
        pipe, link = self.folder / "pipe", self.folder / "link"
        os.mkfifo(pipe)
        with self.assertRaisesRegex(OutputError, "no regular file"):
            WriteText(pipe, "text")
        self.assertTrue(pipe.is_fifo())
        link.symlink_to("target")
        WriteText(link, "text")
        self.assertTrue(link.is_symlink())
        self.assertEqual((self.folder / "target").read_text(), "text")
        link.unlink()
        link.symlink_to("link")
        with self.assertRaises(OutputError):
            WriteText(link, "text")

    def test_a_file_keeps_what_it_held(self):
        path = self.folder / "result.json"
        WriteText(path, "old")
        with room_for(1000), self.assertRaisesRegex(OutputError, "result.json"):
            WriteBytes(path, b"x" * 5000)
        self.assertEqual(path.read_text(), "old")
        self.assertEqual(self.names(), ["result.json"])

    def test_a_campaign_appears_whole_or_not_at_all(self):
        out = self.folder / "out"
        with room_for(1000), self.assertRaisesRegex(OutputError, "large"):
            WriteCampaign(make_campaign(), out)
        self.assertEqual(self.names(), [])
        WriteCampaign(make_campaign(), out)
        self.assertEqual(len(LoadCampaign(out).runs), 4)

    def test_a_command_ends_in_one_line(self):
        out = self.folder / "out"
        # Compiled, or the laws' own files would be the first to find no room.
        self.run_main("predict", policy_path())
        with room_for(200):
            status, said = self.run_main("predict", policy_path(), "--out", out)
        self.assertEqual(status, 2)
        self.assertRegex(said, r"^brace-drake: .*prediction.json.*\n$")
        self.assertFalse(out.exists())

    @unittest.skipUnless(Path("/dev/full").exists(), "no /dev/full")
    def test_a_full_disk_behind_standard_output_is_one_line(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [sys.executable, "-m", "brace_drake.cli.main", "check",
                 str(EXAMPLE)],
                cwd=ROOT,
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
            )  # fmt: skip
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"^brace-drake: .*No space left.*\n$")


class TestFullDiskOfARecording(Folder):
    def setUp(self):
        super().setUp()
        self.columns = columns_of((2,))
        self.journal = Journal(self.folder, HEAD)
        self.run_file = self.new_run()
        self.path = self.folder / "push.csv"

    def new_run(self):
        return self.journal.NewRun("push", self.columns, True, "push", "fit")

    def append(self, count):
        for _ in range(count):
            tick = self.run_file.rows
            row = [tick / 200.0, *[0.14] * (len(self.columns) - 1)]
            self.run_file.Append(row)

    def times(self):
        table = np.loadtxt(self.path, delimiter=",", skiprows=1)
        return table[:, 0].tolist()

    def test_rows_on_the_disk_are_whole_and_none_is_lost_or_written_twice(self):
        self.append(10)
        self.run_file.Flush(now=True)
        size = self.path.stat().st_size
        self.append(40)
        with room_for(size + 5000), self.assertRaises(OutputError):
            self.run_file.Flush(now=True)
        taken = self.times()
        self.assertLess(10, len(taken))
        self.assertLess(len(taken), 50)
        self.assertEqual(self.path.read_bytes()[-1:], b"\n")
        self.assertEqual(len(LoadCampaign(self.folder).runs), 1)
        self.run_file.Close(True, {})
        self.assertEqual(self.times(), [i / 200.0 for i in range(50)])

    def test_a_run_that_never_got_room_leaves_no_trace(self):
        self.append(10)
        with room_for(700), self.assertRaises(OutputError):
            self.run_file.Close(True, {})
        self.assertEqual(self.names(), [])
        self.run_file = self.new_run()
        self.append(10)
        self.run_file.Close(True, {})
        self.assertEqual(self.names(), ["campaign.yaml", "push.csv"])
        self.assertEqual(self.journal.files, ["push.csv"])

    def test_no_room_for_the_manifest_leaves_the_other_runs(self):
        self.append(10)
        self.run_file.Close(True, {})
        self.run_file = self.new_run()
        self.append(10)
        refusal = OSError(28, "No space left on device")
        with mock.patch("os.replace", side_effect=refusal):
            with self.assertRaisesRegex(OutputError, "No space left"):
                self.run_file.Close(True, {})
        self.assertEqual(self.names(), ["campaign.yaml", "push.csv"])
        self.assertEqual(len(LoadCampaign(self.folder).runs), 1)


class TestFullDiskAtTheDevice(Folder):
    def test_the_ring_is_released_and_what_was_recorded_is_valid(self):
        out = self.folder / "out"
        with emulated(limits=PATIENT) as device:
            path = device.terminal.path
            with Recorder(path, BENCH, PATIENT, out) as recorder:
                # What is compiled at first use is compiled by now.
                recorder.Record(short_push(0.1), "fit", 0, NoKeys())
                motion = short_push(20.0)
                with room_for(60_000), self.assertRaises(OutputError):
                    recorder.Record(motion, "fit", 0, NoKeys())
            assert_device_stops(self, device, Cause.HOST_ERROR)
        _, run = LoadCampaign(out).runs
        self.assertGreater(len(run.time_s), 50)
        np.testing.assert_allclose(np.diff(run.time_s), 0.005, atol=1e-9)


class TestNoRoomForCompiledLaws(Folder):
    def setUp(self):
        super().setUp()
        before = numba.config.CACHE_DIR
        self.addCleanup(setattr, numba.config, "CACHE_DIR", before)
        self.tried = []

    def import_all(self, folder):
        self.tried.append(folder)
        if folder == str(self.folder):
            raise OSError(28, "No space left on device")

    def import_into(self, folder):
        said = io.StringIO()
        with (
            mock.patch.object(laws, "_import_all", self.import_all),
            contextlib.redirect_stderr(said),
        ):
            laws._import(str(folder))
        self.assertRegex(
            said.getvalue(), f"^brace-drake: {folder} takes no files.*\n$"
        )
        private = Path(self.tried[-1])
        self.assertEqual(private.stat().st_mode & 0o777, 0o700)
        self.assertEqual(numba.config.CACHE_DIR, str(private))
        private.rmdir()

    def test_a_disk_that_fills_up_leaves_a_folder_of_the_process(self):
        self.import_into(self.folder)
        self.assertEqual(len(self.tried), 2)

    def test_a_home_that_is_read_only_is_not_written_to(self):
        self.import_into("/proc/version/laws")
        self.assertEqual(len(self.tried), 1)


class TestReadOnly(Folder):
    def test_each_writer_has_one_line_and_leaves_no_trace(self):
        self.folder.chmod(0o555)
        self.addCleanup(self.folder.chmod, 0o755)
        path = self.folder / "x"
        writers = {
            "folder": lambda: MakeFolder(path),
            "held folder": lambda: HoldFolder(self.folder),
            "file": lambda: WriteText(path, "text"),
            "campaign": lambda: WriteCampaign(make_campaign(), path),
            "report": lambda: WriteReport({}, [], path),
            "scenario": lambda: SaveScenario(BenchScenario(), path),
            "journal": lambda: Journal(path, HEAD),
        }
        # Who has no rights may not even read the page's template.
        page = mock.patch.object(report_page, "render_page", return_value="x")
        self.enterContext(page)
        for name, write in writers.items():
            with self.subTest(name), without_rights():
                with self.assertRaisesRegex(BraceError, "writ.*: Perm") as it:
                    write()
                self.assertNotIn("\n", str(it.exception))
        self.assertEqual(self.names(), [])

    def test_a_disk_that_refuses_to_remove_as_well_is_told_alike(self):
        # Linux refuses both on a read-only disk, whatever is there.
        refusal = OSError(30, "Read-only file system")
        with (
            mock.patch.object(Path, "open", side_effect=refusal),
            mock.patch.object(Path, "unlink", side_effect=refusal),
            self.assertRaisesRegex(OutputError, "Read-only"),
        ):
            WriteText(self.folder / "x", "text")


_HOLDER = """
import sys
from brace_drake.core.output import HoldFolder
HoldFolder(sys.argv[1])
print("held", flush=True)
sys.stdin.read()
"""
_JOURNAL = """
import sys
from brace_drake.link.operation.journal import Journal
journal = Journal(sys.argv[1], {"device": "bench stage 2", "rate_hz": 200.0})
print("held", flush=True)
sys.stdin.read()
"""
_RACER = """
import sys
from dataclasses import replace
from brace_drake.recording import WriteCampaign
from brace_drake.core.errors import OutputError
from tests.test_campaign_read import make_campaign
campaign = replace(make_campaign(), subject=sys.argv[2])
print("ready", flush=True)
for line in sys.stdin:
    try:
        WriteCampaign(campaign, f"{sys.argv[1]}/{line.strip()}")
        print("won", flush=True)
    except OutputError as error:
        print(error, flush=True)
"""


class TestTwoProcesses(Folder):
    def test_a_command_refuses_a_folder_that_another_process_fills(self):
        out = self.folder / "out"
        holder = self.start(_HOLDER, out)
        holder.stdout.readline()
        for words in (
            ["diagnose", EXAMPLE, "--out", out],
            ["fit", EXAMPLE, "--out", out],
            ["plan", "--motions", "push_fast", "--out", out],
            ["predict", policy_path(), "--out", out],
            ["validate", EXAMPLE, "--out", out],
        ):
            with self.subTest(words[0]):
                status, said = self.run_main(*words)
                self.assertEqual(status, 2)
                self.assertIn("another process", said)
        self.assertEqual(list(out.iterdir()), [])
        # However it ends, it holds no longer.
        holder.kill()
        holder.wait()
        self.assertEqual(
            self.run_main("predict", policy_path(), "--out", out)[0], 0
        )

    def test_two_recordings_do_not_share_a_campaign(self):
        other = self.start(_JOURNAL, self.folder)
        other.stdout.readline()
        with self.assertRaisesRegex(OutputError, "another process"):
            Journal(self.folder, HEAD)
        other.stdin.close()
        other.wait()
        Journal(self.folder, HEAD).Close()

    def test_one_process_may_hold_a_folder_twice_and_gives_it_back(self):
        HoldFolder(self.folder)
        HoldFolder(self.folder)
        ReleaseFolder(self.folder)
        holder = self.start(_HOLDER, self.folder)
        self.assertEqual(holder.stdout.readline(), "held\n")

    def test_of_two_that_write_a_campaign_one_wins_and_nothing_is_mixed(self):
        racers = [self.start(_RACER, self.folder, n) for n in ("a", "b")]
        for racer in racers:
            racer.stdout.readline()
        for i in range(20):
            for racer in racers:
                racer.stdin.write(f"{i}\n")
                racer.stdin.flush()
            said = [racer.stdout.readline() for racer in racers]
            self.assertEqual(said.count("won\n"), 1, said)
            winner = "ab"[said.index("won\n")]
            self.assertEqual(LoadCampaign(self.folder / f"{i}").subject, winner)
        self.assertEqual(len(self.names()), 20)


_REWRITER = """
import sys
from brace_drake.core.output import WriteBytes
print("ready", flush=True)
while True:
    for letter in b"ab":
        WriteBytes(sys.argv[1], bytes([letter]) * 1_000_000)
"""
_CAMPAIGNS = """
import os
import sys
from brace_drake.recording import WriteCampaign
from tests.test_campaign_read import make_campaign
campaign, i = make_campaign(), 0
print("ready", flush=True)
while True:
    WriteCampaign(campaign, f"{sys.argv[1]}/{os.getpid()}-{i}")
    i += 1
"""


class TestKilledInMidWrite(Folder):
    def kill_in_the_middle(self, code, *words):
        draw = np.random.default_rng(3)
        for _ in range(4):
            process = self.start(code, *words)
            process.stdout.readline()
            time.sleep(draw.uniform(0.02, 0.1))
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
            yield

    def test_a_file_is_all_old_or_all_new(self):
        path = self.folder / "file"
        WriteBytes(path, b"a" * 1_000_000)
        for _ in self.kill_in_the_middle(_REWRITER, path):
            data = path.read_bytes()
            self.assertIn(data, (b"a" * 1_000_000, b"b" * 1_000_000))

    def test_a_campaign_is_whole_or_not_there(self):
        for _ in self.kill_in_the_middle(_CAMPAIGNS, self.folder):
            pass
        shown = [n for n in self.names() if not n.startswith(".")]
        for name in shown:
            problems = CheckCampaign(self.folder / name)
            errors = [p for p in problems if p.severity == "error"]
            self.assertEqual(errors, [])


class _Backwards(datetime):
    """A clock that is set back by an hour at each look."""

    _now = datetime(2026, 11, 22, tzinfo=UTC)

    @classmethod
    def now(cls, tz=None):
        cls._now -= timedelta(hours=1)
        return cls._now.astimezone(tz)


class TestClock(Folder):
    def test_a_clock_set_back_in_mid_recording_changes_nothing(self):
        seconds = iter(range(10**9, 0, -3600))
        with (
            mock.patch("time.time", lambda: float(next(seconds))),
            mock.patch(
                "brace_drake.link.operation.recorder.datetime", _Backwards
            ),
            emulated(limits=PATIENT) as device,
            Recorder(
                device.terminal.path, BENCH, PATIENT, self.folder
            ) as recorder,
        ):
            for _ in range(2):
                recorder.Record(short_push(0.4), "fit", 0, NoKeys())
        runs = LoadCampaign(self.folder).runs
        self.assertEqual(len(runs), 2)
        for run in runs:
            np.testing.assert_allclose(np.diff(run.time_s), 0.005, atol=1e-9)

    def test_only_notes_of_when_look_at_a_clock_that_can_be_set_back(self):
        notes = {
            "link/operation/live/observer.py",
            "link/operation/recorder.py",
            "withheld/seals.py",
        }
        looks = {
            *(("time", n) for n in ("time", "time_ns", "localtime", "ctime")),
            *(("datetime", n) for n in ("now", "utcnow", "today")),
            ("date", "today"),
        }
        found = set()
        for path in (ROOT / "brace_drake").rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Attribute) and isinstance(
                    node.value, ast.Name
                ):
                    if (node.value.id, node.attr) in looks:
                        name = path.relative_to(ROOT / "brace_drake")
                        found.add(name.as_posix())
        self.assertEqual(found, notes)


if __name__ == "__main__":
    unittest.main()

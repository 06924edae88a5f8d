"""Ctrl-C at any moment ends a command in one line, with status 130."""

import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from tests.commands import run_command
from tests.shared_data import EXAMPLE

ROOT = Path(__file__).resolve().parents[1]
START = """
import sys
from brace_drake.cli.main import main
print("here", flush=True)
sys.exit(main())
"""

HEARD = (
    signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT,
    signal.SIGXCPU, signal.SIGUSR1, signal.SIGUSR2,
)  # fmt: skip


def hear():
    """Lets a child hear signals that whoever started the tests ignores."""
    for number in HEARD:
        signal.signal(number, signal.SIG_DFL)


class TestInterrupts(unittest.TestCase):
    def stop(self, words, *delays, start=START, number=signal.SIGINT):
        """Standard error and status of a command stopped after each delay."""
        process = subprocess.Popen(
            [sys.executable, "-c", start, *map(str, words)],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=hear,
        )
        with process:
            process.stdout.readline()
            for delay in delays:
                time.sleep(delay)
                process.send_signal(number)
            _, errors = process.communicate(timeout=60)
        return errors, process.returncode

    def assert_stopped(self, words, *delays):
        errors, status = self.stop(words, *delays)
        with self.subTest(delays=delays):
            lines = [e for e in errors.splitlines() if "brace-drake:" in e]
            self.assertNotIn("Traceback", errors)
            self.assertEqual(lines, ["brace-drake: stopped"], errors)
            self.assertEqual(status, 130)

    def test_in_the_first_tenth_of_a_second(self):
        for delay in (0.003, 0.01, 0.02, 0.04, 0.07):
            with tempfile.TemporaryDirectory() as out:
                self.assert_stopped(["fit", EXAMPLE, "--out", out], delay)

    def test_what_a_library_swallows_is_heard_all_the_same(self):
        swallow = START.replace(
            'print("here", flush=True)\n',
            "import brace_drake.cli.main as command, time\n"
            "def deaf(given):\n"
            "    print('here', flush=True)\n"
            "    try:\n"
            "        time.sleep(30.0)\n"
            "    except BaseException:\n"
            "        pass\n"
            "    try:\n"
            "        time.sleep(30.0)\n"
            "    finally:\n"
            "        time.sleep(1.0)\n"
            "        print('in order', file=sys.stderr)\n"
            "command._Run = deaf\n",
        )
        for number in HEARD:
            errors, status = self.stop((), 0.1, start=swallow, number=number)
            self.assertEqual(status, 130)
            self.assertEqual(errors, "in order\nbrace-drake: stopped\n")

    def test_again_and_again(self):
        for delays in ((0.02, 0.001), (0.05, 0.002, 0.002), (1.0, 0.01, 0.01)):
            with tempfile.TemporaryDirectory() as out:
                self.assert_stopped(["fit", EXAMPLE, "--out", out], *delays)

    def test_in_a_place_that_can_raise_nothing(self):
        code = (
            "import os, signal, sys, time\n"
            "from brace_drake.cli import main as command\n"
            "class Last:\n"
            "    def __del__(self):\n"
            "        os.kill(os.getpid(), signal.SIGINT)\n"
            "        time.sleep(0.01)\n"
            "def run(given):\n"
            "    Last()\n"
            "    time.sleep(30)\n"
            "command._Run = run\n"
            "sys.exit(command.main())\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=25,
            preexec_fn=hear,
        )
        self.assertEqual(done.stderr, "brace-drake: stopped\n")
        self.assertEqual(done.returncode, 130)


class TestWords(unittest.TestCase):
    def test_words_that_a_terminal_would_obey_are_refused(self):
        status, out, errors = run_command("check", "a\x1b[31mb")
        self.assertEqual((status, out), (2, ""))
        self.assertTrue(errors.strip().isprintable(), errors)

    def test_names_that_are_no_text_are_printed(self):
        done = subprocess.run(
            [sys.executable, "-m", "brace_drake.cli.main", "check", b"/\xff"],
            cwd=ROOT,
            capture_output=True,
        )
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotIn(b"Traceback", done.stderr)
        self.assertIn(rb"\udcff", done.stdout)


if __name__ == "__main__":
    unittest.main()

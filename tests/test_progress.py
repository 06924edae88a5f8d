"""Progress: a bar on a terminal, a line now and then in a log."""

import io
import sys
import unittest
from unittest import mock

from brace_drake.core import progress


def work(stream, seconds_each: float, steps: int = 200):
    """Tells of some steps of work; the clock is ours."""
    clock = [1000.0]
    with (
        mock.patch.object(sys, "stderr", stream),
        mock.patch.object(progress.time, "monotonic", lambda: clock[0]),
        progress.share_bar() as say,
    ):
        for i in range(steps):
            clock[0] += seconds_each
            say(f"step {i}", (i + 1) / steps)
    return stream.getvalue()


class TestLog(unittest.TestCase):
    def test_what_is_short_leaves_no_line(self):
        self.assertEqual(work(io.StringIO(), 0.01), "")

    def test_long_work_has_a_line_now_and_then(self):
        text = work(io.StringIO(), 1.0)
        *lines, last = text.splitlines()
        self.assertEqual(len(lines), int(200 / progress.LINE_S))
        self.assertRegex(last, r"^done +: +100 % ")
        self.assertNotIn("\r", text)
        # What is being done and its share belong together.
        for line in lines:
            step = int(line.split()[1].rstrip(":"))
            self.assertIn(f" {round((step + 1) / 2):d} % ", line)

    def test_work_that_breaks_off_is_not_told_to_be_done(self):
        stream = io.StringIO()
        with self.assertRaises(KeyError):
            with (
                mock.patch.object(progress, "LINE_S", 0.0),
                mock.patch.object(sys, "stderr", stream),
                progress.share_bar() as say,
            ):
                say("step", 0.5)
                raise KeyError("broken")
        self.assertIn(" 50 % ", stream.getvalue())
        self.assertNotIn("done", stream.getvalue())

    def test_a_log_that_is_full_stops_no_work(self):
        class Full(io.StringIO):
            def write(self, text):
                raise OSError("no space")

        work(Full(), 40.0, steps=3)

    def test_without_standard_error_nothing_is_told(self):
        with (
            mock.patch.object(sys, "stderr", None),
            progress.share_bar() as say,
        ):
            say("step", 0.5)


class TestTerminal(unittest.TestCase):
    def test_a_terminal_has_a_bar(self):
        class Terminal(io.StringIO):
            def isatty(self):
                return True

        text = work(Terminal(), 1.0)
        self.assertIn("\r", text)
        self.assertIn("100 %", text)


if __name__ == "__main__":
    unittest.main()

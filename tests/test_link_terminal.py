"""The link to an emulated device's terminal: no other link is lost for it."""

import os
import tempfile
import unittest
from pathlib import Path

from brace_drake.core.errors import LinkError
from brace_drake.link.emulator.terminal import Terminal
from tests.commands import run_command


class TestLinks(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.link = folder / "brace"

    def open(self):
        terminal = Terminal(self.link)
        self.addCleanup(terminal.disconnect)
        return terminal

    def test_a_link_is_made_and_goes_with_its_terminal(self):
        terminal = self.open()
        self.assertEqual(terminal.path, str(self.link))
        self.assertTrue(os.ttyname(os.open(self.link, os.O_NOCTTY)))
        terminal.disconnect()
        self.assertFalse(os.path.lexists(self.link))
        terminal.connect()
        self.assertTrue(self.link.is_symlink())

    def test_what_somebody_has_there_stays_and_no_device_begins(self):
        file = self.link.with_name("file")
        file.write_text("kept")
        other = Terminal()
        self.addCleanup(other.disconnect)
        for target in (file, "nowhere", "brace", other.path, "/dev/null"):
            self.link.symlink_to(target)
            with self.subTest(target=str(target)):
                status, said, errors = run_command(
                    "emulate", "--link", self.link, "--duration", "0.1"
                )
                self.assertEqual((status, said), (2, ""), errors)
                self.assertIn("exists, and no emulated device", errors)
                self.assertEqual(errors.count("\n"), 1)
                self.assertEqual(os.readlink(self.link), str(target))
            self.link.unlink()
        self.assertEqual(file.read_text(), "kept")

    def test_a_file_or_a_folder_stays(self):
        self.link.write_text("kept")
        with self.assertRaisesRegex(LinkError, "exists"):
            self.open()
        self.assertEqual(self.link.read_text(), "kept")

    def test_the_link_of_a_device_that_was_killed_is_taken_over(self):
        for number in (None, 999_999):
            killed = Terminal()
            gone = killed.path
            killed.disconnect()
            if number is not None:
                gone = gone.rstrip("0123456789") + str(number)
            self.link.symlink_to(gone)
            terminal = self.open()
            self.assertNotEqual(os.readlink(self.link), "")
            self.assertTrue(os.path.exists(self.link))
            terminal.disconnect()
            self.assertFalse(os.path.lexists(self.link))

    def test_a_link_that_leads_elsewhere_by_now_is_not_removed(self):
        terminal = self.open()
        self.link.unlink()
        self.link.symlink_to("elsewhere")
        terminal.disconnect()
        self.assertEqual(os.readlink(self.link), "elsewhere")


if __name__ == "__main__":
    unittest.main()

"""The suite's own runner: what it counts, and how it ends."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Counted by hand: two pass, two fail (one of them twice, in two parts).
MIXED = """
import unittest
class TestMixed(unittest.TestCase):
    def test_a(self): print("kept back")
    def test_b(self): self.fail("told")
    def test_c(self):
        for i in range(2):
            with self.subTest(i=i): self.fail("part")
    @unittest.skip("no")
    def test_d(self): pass
    @unittest.expectedFailure
    def test_e(self): self.fail("foreseen")
"""
SOUND = """
import unittest
class TestSound(unittest.TestCase):
    def test_a(self): pass
"""
DEADLY = """
import os, unittest
class TestDeadly(unittest.TestCase):
    def test_a(self): os._exit(3)
"""


class TestRunTests(unittest.TestCase):
    def run_files(self, *words, **sources):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in sources.items():
                Path(folder, f"{name}.py").write_text(text)
            done = subprocess.run(
                [
                    sys.executable,
                    ROOT / "tools" / "run_tests.py",
                    *sources,
                    *words,
                ],
                env={**os.environ, "PYTHONPATH": folder},
                capture_output=True,
                text=True,
                timeout=120,
            )
        return done.returncode, done.stdout.splitlines()

    def test_it_counts_and_tells_what_failed(self):
        status, lines = self.run_files(mixed=MIXED, sound=SOUND)
        self.assertEqual(status, 1)
        self.assertEqual(lines[-1], "3 passed, 2 failed")
        self.assertTrue(lines[-2].startswith("1 skipped"))
        self.assertIn("failed: mixed.TestMixed.test_b", lines)
        self.assertIn("AssertionError: told", lines)
        self.assertNotIn("kept back", lines)

    def test_all_sound_is_status_0(self):
        status, lines = self.run_files(sound=SOUND)
        self.assertEqual((status, lines[-1]), (0, "1 passed, 0 failed"))

    def test_a_process_that_dies_fails_its_file_alone(self):
        sound = {f"sound{i}": SOUND for i in range(40)}
        status, lines = self.run_files(deadly=DEADLY, **sound)
        self.assertEqual((status, lines[-1]), (1, "40 passed, 1 failed"))
        self.assertIn("failed: deadly", lines)

    def test_a_command_that_fails_beside_the_tests_is_told(self):
        for code in (0, 4):
            command = f"echo seen; exit {code}"
            with self.subTest(code):
                status, lines = self.run_files("--also", command, sound=SOUND)
                self.assertEqual(status, int(code > 0))
                self.assertEqual(f"failed: {command}" in lines, code > 0)
                self.assertEqual("seen" in lines, code > 0)

    def test_a_file_that_cannot_be_imported_is_a_failure(self):
        status, lines = self.run_files(broken="import nowhere_at_all\n")
        self.assertEqual((status, lines[-1]), (1, "0 passed, 1 failed"))


if __name__ == "__main__":
    unittest.main()

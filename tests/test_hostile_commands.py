"""Commands on what no one should give them: status 2, and one line of it."""

import json
import os
import pty
import shutil
import tempfile
import unittest
from pathlib import Path

from brace_drake.core.errors import is_plain
from brace_drake.core.resources import scenario_path
from tests.commands import run_command
from tests.reader_fuzz import time_limit
from tests.shared_data import EXAMPLE

RUN, MANIFEST = "push.csv", "campaign.yaml"
MAP = """
format: brace-import/1
device: pad bench
columns: {time_s: t, displacement_m: x, force_N: f}
runs:
- {file: a.csv}
"""


class CommandCase(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.campaign = self.folder / "campaign"
        self.out = self.folder / "out"
        shutil.copytree(EXAMPLE, self.campaign)

    def refused(self, *words):
        """All lines of a command that ends with status 2."""
        status, said, errors = run_command(*words)
        self.assertEqual(status, 2, said + errors)
        self.assertFalse(self.out.exists())
        if words[0] == "check" and said:
            *lines, last = said.splitlines()
            self.assertIn("not usable", last)
        else:
            lines = errors.splitlines()
            self.assertEqual(len(lines), 1, errors)
        for line in lines:
            self.assertTrue(is_plain(line), line)
        return "\n".join(lines)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path


class TestNoFiles(CommandCase):
    def assert_named(self, path, *words):
        """What is no file in a file's place is named, and not waited for."""
        path.unlink(missing_ok=True)
        # Imports are no part of it.
        self.assertEqual(run_command(*words)[0], 2)
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        self.addCleanup(os.close, slave)
        terminal = os.ttyname(slave)
        for kind, make in (
            ("a pipe", os.mkfifo),
            ("a device", lambda p: p.symlink_to("/dev/zero")),
            ("a device", lambda p: p.symlink_to(terminal)),
        ):
            make(path)
            with self.subTest(words[0], kind=kind):
                with time_limit(5.0):
                    told = self.refused(*words)
                self.assertIn(f"{path.name}: cannot be read: is {kind}", told)
            path.unlink()

    def test_a_pipe_a_device_or_a_terminal_as_run(self):
        path = self.campaign / RUN
        self.assert_named(path, "check", self.campaign)
        self.assert_named(path, "diagnose", self.campaign, "--out", self.out)

    def test_a_pipe_a_device_or_a_terminal_as_manifest(self):
        path = self.campaign / MANIFEST
        self.assert_named(path, "check", self.campaign)
        self.assert_named(path, "diagnose", self.campaign, "--out", self.out)

    def test_a_pipe_a_device_or_a_terminal_as_policy(self):
        path = self.folder / "policy.npz"
        self.assert_named(path, "predict", path, "--out", self.out)

    def test_a_pipe_a_device_or_a_terminal_as_scenario(self):
        path = self.folder / "own.scenario.yaml"
        self.assert_named(path, "check", EXAMPLE, "--scenario", path)
        words = "--motion", "push", "--out", self.out
        self.assert_named(path, "simulate", path, *words)

    def test_a_pipe_a_device_or_a_terminal_as_map_or_table(self):
        path = self.folder / "map.yaml"
        self.assert_named(path, "import", path, "--out", self.out)
        path.write_text(MAP)
        table = self.folder / "a.csv"
        self.assert_named(table, "import", path, "--out", self.out)


class TestSizes(CommandCase):
    def test_no_command_begins_with_runs_of_two_or_three_rows(self):
        every = sorted(p.name for p in EXAMPLE.glob("*.csv"))
        for files in ([RUN], every):
            for rows in (2, 3):
                for name in files:
                    lines = (EXAMPLE / name).read_text().splitlines()
                    text = "\n".join(lines[: rows + 1]) + "\n"
                    (self.campaign / name).write_text(text)
                for command in ("check", "diagnose", "fit", "validate"):
                    out = () if command == "check" else ("--out", self.out)
                    with self.subTest(command, rows=rows):
                        told = self.refused(command, self.campaign, *out)
                        self.assertIn(f"{rows} data rows", told)
                        self.assertIn("10 or more", told)

    def test_columns_of_a_lab_that_nobody_asks_for(self):
        names = ",".join(f"c{i}" for i in range(60_000))
        fields = ",".join(["1.5"] * 60_000)
        rows = [f"{0.01 * i:.2f},{i % 9},{i % 7},{fields}" for i in range(20)]
        self.write("a.csv", "\n".join([f"t,x,f,{names}", *rows]))
        path = self.write("map.yaml", MAP)
        with time_limit(5.0):
            status, _, errors = run_command("import", path, "--out", self.out)
        self.assertEqual(status, 0, errors)
        shutil.rmtree(self.out)
        path.write_text(MAP.replace("x,", "xx,"))
        told = self.refused("import", path, "--out", self.out)
        self.assertIn("no column 'xx', did you mean x?", told)

    def test_limits_of_names_of_files(self):
        for name in ("f" * 300, "f" * 300 + ".csv", "f/" * 3000):
            path = self.write("map.yaml", MAP.replace("a.csv", name))
            with self.subTest(name[:3], length=len(name)):
                self.refused("import", path, "--out", self.out)


class TestNames(CommandCase):
    def test_files_whose_names_a_terminal_would_obey(self):
        path = self.campaign / MANIFEST
        text = path.read_text()
        for name in (r"\e[31m.csv", r"\ud800.csv", r"\u202e.csv", r"\x9b1m"):
            path.write_text(text.replace(RUN, f'"{name}"', 1))
            for words in (
                ("check", self.campaign),
                ("check", self.campaign, "--json"),
                ("diagnose", self.campaign, "--out", self.out),
            ):
                with self.subTest(name, words=words[0]):
                    if "--json" not in words:
                        self.assertIn(MANIFEST, self.refused(*words))
                        continue
                    status, said, _ = run_command(*words)
                    self.assertEqual(status, 2)
                    self.assertTrue(json.loads(said)["problems"])
                    self.assertTrue(is_plain(said.replace("\n", " ")), said)

    def test_columns_whose_names_a_terminal_would_obey(self):
        rows = "".join(f"{0.01 * i:.2f},{i % 9},1\n" for i in range(50))
        path = self.write("map.yaml", MAP)
        for name in ("\x1b[31mf", "\u202ef", "\x9b31mf", "\x7ff"):
            self.write("a.csv", f"t,x,{name}\n{rows}")
            with self.subTest(name):
                told = self.refused("import", path, "--out", self.out)
                self.assertIn("no column 'f'", told)

    def test_words_in_a_table_that_a_terminal_would_obey(self):
        path = self.campaign / RUN
        lines = path.read_text().splitlines()
        fields = lines[5].split(",")
        for word in ("\x1b[31m", "\u202e", "\x9b31m"):
            lines[5] = ",".join([*fields[:3], word, *fields[4:]])
            path.write_text("\n".join(lines) + "\n")
            with self.subTest(word):
                told = self.refused("check", self.campaign)
                self.assertIn(f"{RUN}, row 5", told)
                self.assertIn("is not a number", told)

    def test_half_a_character_in_a_table_of_json_is_written_as_an_escape(self):
        rows = [{"t": 0.01 * i, "x": i, "\ud800": i % 7} for i in range(50)]
        table = self.write("a.json", json.dumps(rows))
        status, said, errors = run_command("import", "--init", table)
        self.assertEqual(status, 0, errors)
        self.assertIn(r"\ud800", said)
        self.assertTrue(said.encode())
        path = self.write("map.yaml", MAP.replace("a.csv", "a.json"))
        told = self.refused("import", path, "--out", self.out)
        self.assertIn(r"\ud800", told)


class TestScenarios(CommandCase):
    def test_a_number_in_no_way_of_ours_is_told_with_its_key(self):
        text = scenario_path("bench.scenario.yaml").read_text()
        path = self.folder / "own.scenario.yaml"
        for value in ("0x" + "f" * 5000, "1" + ":59" * 2000, "2024-99-99"):
            path.write_text(text.replace("0.0002", value, 1))
            told = self.refused("check", EXAMPLE, "--scenario", path)
            self.assertIn("time_step is ", told)
            self.assertLess(len(told), 500)


if __name__ == "__main__":
    unittest.main()

"""Readers end in a result or in one line, whatever a file holds."""

import contextlib
import os
import tempfile
import unittest
from pathlib import Path

try:
    from hypothesis import given, settings
    from hypothesis import strategies as st
except ImportError as error:
    raise unittest.SkipTest(
        "hypothesis is not installed: pip install -e '.[dev]'"
    ) from error

from brace_drake.core.errors import BraceError
from brace_drake.learning.policy import LoadPolicy
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.load import LoadScenario
from brace_drake.torso.scan import LoadScan
from tests.reader_fuzz import READERS, Bench, HangError, Reader, time_limit

# Repeatable, and short: tools/fuzz_readers.py goes on from here.
FEW = settings(max_examples=25, deadline=None, derandomize=True, database=None)
YAML = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)


class TestDamagedFiles(unittest.TestCase):
    def assert_survives(self, reader):
        bench = Bench(reader)
        self.addCleanup(bench.close)

        @FEW
        @given(st.integers(0, 2**40))
        def survives(seed):
            problem = bench.try_case(seed)
            self.assertIsNone(problem, f"{reader.name}, seed {seed}")

        survives()

    def test_no_reader_breaks_hangs_or_looks_elsewhere(self):
        for reader in READERS:
            with self.subTest(reader=reader.name):
                self.assert_survives(reader)


class TestNoFiles(unittest.TestCase):
    def test_no_reader_waits_for_what_is_no_file(self):
        for reader in READERS:
            bench = Bench(reader)
            self.addCleanup(bench.close)
            files = [p for p in bench.sound.iterdir() if p.suffix != ".csv"]
            for path in files or list(bench.sound.iterdir()):
                path.unlink()
                for make in (
                    os.mkfifo,
                    lambda p: p.symlink_to("/dev/zero"),
                    lambda p: p.symlink_to("/dev/tty"),
                    Path.mkdir,
                ):
                    make(path)
                    with self.subTest(reader=reader.name, file=path.name):
                        with contextlib.suppress(BraceError), time_limit(5.0):
                            self.assertIsNone(reader.read(bench.sound))
                    path.rmdir() if path.is_dir() else path.unlink()


class TestAnyContent(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    @FEW
    @given(YAML)
    def test_any_yaml_in_place_of_a_scenario_or_a_manifest(self, tree):
        import yaml

        text = yaml.safe_dump(tree, allow_unicode=True)
        for name, read in (
            ("x.scenario.yaml", LoadScenario),
            ("campaign.yaml", lambda path: LoadCampaign(path.parent)),
        ):
            path = self.folder / name
            path.write_text(text, encoding="utf-8", errors="replace")
            try:
                read(path)
            except BraceError as error:
                self.assertNotIn("\n", str(error).strip())

    @FEW
    @given(st.binary(max_size=400))
    def test_any_bytes_in_place_of_a_policy_or_a_scan(self, data):
        for name, read in (
            ("x.npz", LoadPolicy),
            *((f"x{ending}", LoadScan) for ending in (".ply", ".stl", ".obj")),
        ):
            path = self.folder / name
            path.write_bytes(data)
            with self.assertRaises(BraceError):
                read(path)


class TestWatch(unittest.TestCase):
    """What the others rely on does see a reader that misbehaves."""

    def problem_of(self, read):
        def write(folder):
            (folder / "file").write_bytes(b"sound")

        calls = []

        def sound_first(folder):
            calls.append(folder)
            if len(calls) > 1:
                read(folder)

        bench = Bench(Reader("bad", write, sound_first, ("*",)))
        self.addCleanup(bench.close)
        return bench.try_case(1)

    def test_a_reader_that_looks_elsewhere_is_found_out(self):
        beside = Path(tempfile.gettempdir()) / "brace-drake-absent"

        def look(folder):
            beside.open()

        self.assertIn("opens", self.problem_of(look))

    def test_a_reader_that_writes_is_found_out(self):
        found = self.problem_of(lambda folder: (folder / "x").write_text(""))
        self.assertIn("writes", found)

    def test_a_reader_that_unpickles_is_found_out(self):
        import pickle

        data = pickle.dumps(BraceError)
        found = self.problem_of(lambda folder: pickle.loads(data))
        self.assertIn("pickle.find_class", found)

    def test_a_reader_that_raises_or_hangs_is_found_out(self):
        found = self.problem_of(lambda folder: [][1])
        self.assertIn("IndexError", found)
        with self.assertRaises(HangError), time_limit(0.05):
            while True:
                pass


if __name__ == "__main__":
    unittest.main()

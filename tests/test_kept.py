"""Compiled code follows its sources."""

import contextlib
import io
import os
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path
from unittest import mock

from brace_drake.core import resources
from brace_drake.core.resources import takes_files
from brace_drake.effects.actuation import (
    coulomb_friction,
    loose_drive,
    stribeck_friction,
)
from brace_drake.effects.mechanism import leg_compliance
from brace_drake.laws.kept import (
    folder_of_sources,
    sources_of,
)

_INNER = """
from brace_drake.laws.compiled import compiled_law

FACTOR = {factor}


@compiled_law
def scaled(x):
    return FACTOR * x
"""
_OUTER = """
from brace_drake.laws.compiled import compiled_law
from inner import scaled


@compiled_law
def twice(x):
    return 2.0 * scaled(x)


print(twice(1.0))
"""


class TestKept(unittest.TestCase):
    def test_a_change_in_a_function_that_is_called_is_seen(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "package"
            folder.mkdir()
            (folder / "outer.py").write_text(textwrap.dedent(_OUTER))
            printed = []
            for factor in (3.0, 5.0):
                inner = textwrap.dedent(_INNER).format(factor=factor)
                (folder / "inner.py").write_text(inner)
                # -B: Python's own files tell a change by size and second.
                done = subprocess.run(
                    [sys.executable, "-B", str(folder / "outer.py")],
                    capture_output=True,
                    text=True,
                    check=True,
                )
                printed.append(float(done.stdout))
        self.assertEqual(printed, [6.0, 10.0])

    def test_a_folder_is_named_after_its_sources(self):
        actuation = Path(coulomb_friction.__file__).parent
        self.assertEqual(actuation, Path(stribeck_friction.__file__).parent)
        kept = folder_of_sources(actuation)
        self.assertRegex(kept.name, r"^actuation-[0-9a-f]{16}$")
        with tempfile.TemporaryDirectory() as name:
            one = Path(name) / "actuation"
            one.mkdir()
            self.assertNotEqual(folder_of_sources(one), kept)

    def test_effects_are_compiled_anew_with_what_they_call_in_other_folders(
        self,
    ):
        mechanism = Path(leg_compliance.__file__).parent
        called = Path(loose_drive.__file__)
        self.assertNotEqual(mechanism, called.parent)
        self.assertIn(called, sources_of(mechanism))

    def test_what_cannot_be_written_to_takes_no_files(self):
        self.assertFalse(takes_files(Path("/proc/version/laws")))


class TestPlaces(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(
            mock.patch.object(tempfile, "tempdir", str(self.folder))
        )
        self.other = self.folder / f"brace_drake-{os.getuid()}"

    def place(self, home, **variables):
        """Where a new process keeps code, and what it says of it."""
        for kept in (resources._kept_in, resources.takes_files):
            kept.cache_clear()
            self.addCleanup(kept.cache_clear)
        said = io.StringIO()
        variables = {"XDG_CACHE_HOME": "", "HOME": str(home), **variables}
        with (
            mock.patch.dict(os.environ, variables),
            contextlib.redirect_stderr(said),
        ):
            return resources.cache_path("x"), said.getvalue()

    def test_the_users_cache_is_taken_where_it_takes_files(self):
        home = self.folder / "home"
        there = home / ".cache" / "brace_drake" / "x"
        self.assertEqual(self.place(home), (there, ""))
        there = self.folder / "other" / "brace_drake" / "x"
        found = self.place(home, XDG_CACHE_HOME=str(self.folder / "other"))
        self.assertEqual(found, (there, ""))

    def test_else_a_temporary_one_that_is_told_once_and_found_again(self):
        for home in ("/proc/version", "/dev/null", "/proc/nowhere"):
            place, said = self.place(home)
            with self.subTest(home):
                self.assertEqual(place, self.other / "x")
                self.assertEqual(self.other.stat().st_mode & 0o777, 0o700)
                self.assertRegex(
                    said,
                    f"^brace-drake: {home}/.cache/brace_drake takes no files"
                    f".* in {self.other}.*XDG_CACHE_HOME.*\\n$",
                )
                self.assertEqual(self.place(home), (place, ""))
            self.other.rmdir()

    def test_a_temporary_one_that_others_can_write_to_is_not_taken(self):
        wanted = Path("/proc/version/.cache/brace_drake/x")
        theirs = self.folder / "theirs"
        theirs.mkdir()
        self.other.symlink_to(theirs)
        self.assertEqual(self.place("/proc/version")[0], wanted)
        self.other.unlink()
        self.other.mkdir()
        self.other.chmod(0o777)
        self.assertEqual(self.place("/proc/version")[0], wanted)


if __name__ == "__main__":
    unittest.main()

"""Compiled code follows its sources."""

import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path

from brace_drake.effects.actuation import (
    coulomb_friction,
    loose_drive,
    stribeck_friction,
)
from brace_drake.effects.mechanism import leg_compliance
from brace_drake.laws.kept import (
    folder_of_sources,
    sources_of,
    takes_files,
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


if __name__ == "__main__":
    unittest.main()

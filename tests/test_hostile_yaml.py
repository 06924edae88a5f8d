"""YAML that was made to break a reader, in each place of each kind of file."""

import re
import tempfile
import unittest
from pathlib import Path

from brace_drake.core.errors import BraceError, is_plain
from tests.reader_fuzz import READERS, time_limit

LAUGHS = "[&a [x, x, x, x, x, x, x, x, x, x], {}]".format(
    ", ".join(
        f"&{new} [{', '.join([f'*{old}'] * 10)}]"
        for old, new in zip("abcdefgh", "bcdefghi", strict=True)
    )
)
# More digits than Python makes a whole number of, or one of so many.
NUMBERS = {
    "hexadecimal": "0x" + "f" * 5000,
    "octal": "0o" + "7" * 5000,
    "octal of old": "0" + "7" * 5000,
    "binary": "0b" + "1" * 5000,
    "decimal": "9" * 5000,
    "sexagesimal": "1" + ":59" * 2000,
    "sexagesimal fraction": "1" + ":59" * 2000 + ".5",
}
DATES = {
    "day that is none": "2024-99-99",
    "year that is none": "0000-00-00",
    "time that is none": "2024-01-01T99:99:99Z",
    "zone that is none": "2024-01-01 00:00:00 +99:99",
    "exact to the attosecond": "2024-01-01 00:00:00." + "9" * 18,
}
DEEP = {"lists": "[" * 5000, "maps": "{a: " * 5000, "closed": "[" * 5000 + "]"}


class TestHostileYaml(unittest.TestCase):
    def setUp(self):
        self.files = []
        for reader in READERS:
            folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
            reader.write(folder)
            paths = folder.glob("*.yaml")
            self.files += [(reader, p, p.read_text()) for p in paths]

    def put(self, value):
        """A value after each key of each file: its reader, path and text."""
        for reader, path, text in self.files:
            lines = text.splitlines()
            for i, line in enumerate(lines):
                key = re.match(r"[-\s]*[^\s#]+:(?= )", line)
                if key:
                    changed = [*lines[:i], f"{key[0]} {value}", *lines[i + 1 :]]
                    yield reader, path, "\n".join(changed)

    def read(self, values):
        """How many files have been read; none may break or hold its reader."""
        count = 0
        for title, value in values.items():
            for reader, path, text in self.put(value):
                path.write_text(text)
                try:
                    with time_limit(5.0):
                        reader.read(path.parent)
                except BraceError as error:
                    self.assertTrue(is_plain(str(error)), error)
                except Exception as error:
                    self.fail(f"{title} in {path.name}: {error!r}")
                count += 1
        return count

    def test_every_kind_of_file_is_asked(self):
        names = {path.stem for _, path, _ in self.files}
        kinds = {"campaign", "bench.scenario", "limits", "plan", "map"}
        self.assertLessEqual(kinds, names)
        self.assertGreater(self.read({"word": "word"}), 200)

    def test_aliases_that_multiply_after_any_key(self):
        self.read({"aliases": LAUGHS})

    def test_numbers_of_thousands_of_digits_after_any_key(self):
        self.read(NUMBERS)

    def test_dates_that_are_none_after_any_key(self):
        self.read(DATES)

    def test_thousands_of_levels_after_any_key(self):
        self.read(DEEP)


if __name__ == "__main__":
    unittest.main()

"""`make test` runs the suite in parts; together they are the whole of it."""

import re
import unittest
from fnmatch import fnmatch
from pathlib import Path

TESTS = Path(__file__).resolve().parent


class TestParts(unittest.TestCase):
    def test_every_file_of_tests_is_in_one_part(self):
        makefile = (TESTS.parent / "Makefile").read_text()
        parts = re.search(r"^PARTS := (.*)$", makefile, re.M).group(1).split()
        found = dict(re.findall(r"^(\S+): FILES := (\S+)$", makefile, re.M))
        self.assertEqual(set(found), {"test_link", *parts})
        recipe = re.search(r"^test: lint\n((?:\t.*\n)+)", makefile, re.M)[1]
        self.assertIn(" test_link ", recipe)
        self.assertIn(" $(PARTS)", recipe)
        for path in TESTS.rglob("test_*.py"):
            self.assertEqual(path.parent, TESTS)
            with self.subTest(file=path.name):
                these = [p for p in found.values() if fnmatch(path.name, p)]
                self.assertEqual(len(these), 1, these)


if __name__ == "__main__":
    unittest.main()

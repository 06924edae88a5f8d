"""Well-formed hostile files of each format end in a result or in one line."""

import unittest

try:
    from tests.hostile import formats, try_format
except ImportError as error:
    raise unittest.SkipTest(
        "hypothesis is not installed: pip install -e '.[dev]'"
    ) from error

# Repeatable, and short: tools/fuzz_files.py goes on from here.
FILES, SEED = 40, 7


class TestHostileFormats(unittest.TestCase):
    def test_no_reader_breaks_or_hangs(self):
        for name in formats():
            found, read = [], []

            def told(data, problem, found=found, read=read):
                read.append(data)
                if problem:
                    found.append((problem, data[:300]))

            with self.subTest(format=name):
                try_format(name, FILES, SEED, told)
                self.assertEqual(found[:1], [])
                self.assertGreaterEqual(len(read), FILES // 2)


if __name__ == "__main__":
    unittest.main()

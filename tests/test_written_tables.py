"""Tables for spreadsheets, and files that belong together."""

import csv
import io
import tempfile
import unittest
from pathlib import Path

from brace_drake.core.csv_text import csv_text
from brace_drake.core.errors import OutputError
from brace_drake.core.output import WriteFiles
from tests.test_disk import room_for


def cells_of(text):
    return list(csv.reader(io.StringIO(text)))


class TestCsvText(unittest.TestCase):
    def test_no_text_is_a_formula(self):
        for hostile in ("=1+1", "+A1", "-cmd|' /C calc'!A0", "@SUM(A1)"):
            with self.subTest(hostile):
                head, row = cells_of(csv_text([hostile], [[hostile]]))
                self.assertEqual(head, [f"'{hostile}"])
                self.assertEqual(row, [f"'{hostile}"])

    def test_numbers_and_plain_text_stay(self):
        row = [-1.5, "-1.5e-3", "+2", "leg 2 - anchor", "a,b", None]
        _, found = cells_of(csv_text("abcdef", [row]))
        self.assertEqual(
            found, ["-1.5", "-1.5e-3", "+2", "leg 2 - anchor", "a,b", ""]
        )

    def test_rows_by_name_take_the_order_of_the_head(self):
        rows = [{"b": 2, "a": 1}, {"a": 3}]
        found = cells_of(csv_text(["a", "b"], rows))
        self.assertEqual(found, [["a", "b"], ["1", "2"], ["3", ""]])


class TestFilesTogether(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        self.files = {
            self.folder / "small": b"1",
            self.folder / "text": "h\u00e4lt",
            self.folder / "large": b"0" * 5000,
        }

    def test_all_are_there(self):
        WriteFiles(self.files)
        self.assertEqual(len(list(self.folder.iterdir())), 3)
        self.assertEqual((self.folder / "text").read_text("utf-8"), "h\u00e4lt")
        self.assertEqual((self.folder / "large").stat().st_size, 5000)

    def test_on_a_full_disk_none_is_and_old_ones_stay(self):
        (self.folder / "small").write_bytes(b"old")
        with room_for(1000), self.assertRaisesRegex(OutputError, "large"):
            WriteFiles(self.files)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["small"])
        self.assertEqual((self.folder / "small").read_bytes(), b"old")


if __name__ == "__main__":
    unittest.main()

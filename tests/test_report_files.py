"""A diagnosis as one page, as figures and as tables for a paper."""

import csv
import re
import tempfile
import unittest
import zlib
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import OutputError
from brace_drake.report import RunTrace
from brace_drake.report.export import WriteFigures, WritePdf, WriteTables
from brace_drake.report.export.tables import latex_text
from brace_drake.report.viewer.decimate import decimate
from tests.diagnoses import make_diagnosis, make_partly, make_without_gap

CHANNELS = ("ring2_force_y_N", "ring2_y_virtual_m")


def make_trace() -> RunTrace:
    time = np.arange(400) / 200.0
    measured = np.column_stack([np.sin(time), 1e-3 * np.cos(time)])
    floor = np.array([0.05, 2e-6])
    return RunTrace(
        "validation push/1",
        "validation",
        time,
        CHANNELS,
        measured,
        measured + 5.0 * floor,
        measured + floor,
        floor,
    )


def text_of(pdf: bytes) -> str:
    """All strings that a PDF shows, without what stands between them."""
    shown = []
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.S):
        try:
            content = zlib.decompress(stream)
        except zlib.error:
            continue
        shown += re.findall(rb"\(((?:[^()\\]|\\.)*)\)", content)
    # Two bytes a character in some versions of matplotlib, one in others.
    text = b"".join(shown).replace(b"\x00", b"").decode("latin-1")
    return re.sub(r"\\(.)", r"\1", text)


def letters(text: str) -> str:
    """Text without spaces, and without what a font may join: fi, fl, ff."""
    return re.sub(r"ff[il]?|f[il]|[^!-~]", "", text)


class TestReportFiles(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_the_pdf_has_one_page_that_says_the_verdict(self):
        for make in (make_diagnosis, make_partly, make_without_gap):
            with self.subTest(make.__name__):
                diagnosis = make()
                (path,) = WritePdf(diagnosis, [make_trace()], self.folder)
                content = path.read_bytes()
                self.assertEqual(len(re.findall(rb"/Type /Page\b", content)), 1)
                sentence = diagnosis["verdict"]["sentence"]
                self.assertIn(letters(sentence), letters(text_of(content)))
        self.assertEqual(list(self.folder.iterdir()), [path])

    def test_csv_has_the_numbers_of_the_diagnosis_as_they_are(self):
        diagnosis = make_diagnosis()
        files = {p.stem: p for p in WriteTables(diagnosis, self.folder, "csv")}
        for name, rows in (
            ("runs", diagnosis["runs"]),
            ("subject", diagnosis["subject"]["parameters"]),
            ("validation_channels", diagnosis["shrink"]["channels"]),
            ("power_by_block", diagnosis["where"]["attribution"]),
        ):
            with files[name].open(newline="") as file:
                read = list(csv.DictReader(file))
            self.assertEqual(len(read), len(rows))
            for line, row in zip(read, rows, strict=True):
                for key in set(line) & set(row):
                    with self.subTest(table=name, column=key):
                        value = row[key]
                        is_real = isinstance(value, float)
                        found = float(line[key]) if is_real else line[key]
                        told = "" if value is None else value
                        self.assertEqual(found, told if is_real else str(told))

    def test_a_table_without_rows_is_no_file(self):
        names = [
            p.stem for p in WriteTables(make_diagnosis(), self.folder, "csv")
        ]
        self.assertNotIn("law", names)
        self.assertIn("effects", names)

    def test_latex_escapes_its_special_characters(self):
        text = latex_text((("a_b", "n"), [["50 % & $x_1$", -0.00123456]]))
        self.assertIn(r"a b & n \\", text)
        self.assertIn(r"50 \% \& \$x\_1\$ & $-$0.001235 \\", text)
        self.assertIn(r"\begin{tabular}{lr}", text)

    def test_every_figure_is_a_file_of_its_format(self):
        diagnosis, begins = (
            make_diagnosis(),
            {"png": b"\x89PNG", "pdf": b"%PDF"},
        )
        with mock.patch(
            "brace_drake.report.export.figures.draw_power", return_value=None
        ):
            for form, first in begins.items():
                files = WriteFigures(
                    diagnosis, [make_trace()], [], self.folder, form
                )
                names = [p.name for p in files]
                self.assertIn(f"gap.{form}", names)
                self.assertIn(f"run_validation_push_1.{form}", names)
                # What cannot be drawn is no file.
                self.assertNotIn(f"power_by_channel.{form}", names)
                for path in files:
                    self.assertTrue(path.read_bytes().startswith(first))

    def test_a_place_that_cannot_be_written_is_one_clear_line(self):
        file = self.folder / "file"
        file.write_text("kept")
        with self.assertRaises(OutputError):
            WriteTables(make_diagnosis(), file, "csv")
        with self.assertRaises(OutputError):
            WritePdf(make_diagnosis(), [], file)
        self.assertEqual(file.read_text(), "kept")


class TestDecimate(unittest.TestCase):
    def test_no_peak_is_lost_and_time_rises(self):
        values = np.zeros((10_000, 2))
        values[777, 0], values[8123, 1] = 5.0, -3.0
        time = np.arange(10_000) / 200.0
        times, kept = decimate(time, values, 500)
        self.assertLessEqual(len(times), 500)
        self.assertEqual(kept[:, 0].max(), 5.0)
        self.assertEqual(kept[:, 1].min(), -3.0)
        self.assertTrue((np.diff(times) > 0.0).all())
        # The peak is where it was, to the width of a piece.
        self.assertAlmostEqual(
            times[kept[:, 0].argmax()], time[777], delta=40 / 200.0
        )

    def test_what_is_short_or_missing_stays_as_it_is(self):
        values = np.full((100, 1), np.nan)
        time = np.arange(100.0)
        self.assertIs(decimate(time, values, 100)[1], values)
        self.assertTrue(np.isnan(decimate(time, values, 10)[1]).all())


if __name__ == "__main__":
    unittest.main()

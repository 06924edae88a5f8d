"""Recordings that were made to break a reader end in lines with their place."""

import os
import shutil
import tempfile
import unittest
import warnings
from pathlib import Path

import yaml

from brace_drake.core.errors import CampaignError
from brace_drake.recording import CheckCampaign, LoadCampaign
from tests.reader_fuzz import time_limit
from tests.shared_data import EXAMPLE

RUN = "push.csv"


class TestHostileTables(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.path = folder / "campaign"
        self.path.mkdir()
        manifest = yaml.safe_load((EXAMPLE / "campaign.yaml").read_text())
        manifest["runs"] = [r for r in manifest["runs"] if r["file"] == RUN]
        (self.path / "campaign.yaml").write_text(yaml.safe_dump(manifest))
        lines = (EXAMPLE / RUN).read_text().splitlines()
        self.header, *self.rows = lines[:400]
        self.put(self.rows)

    def put(self, rows, header=None):
        lines = [self.header if header is None else header, *rows]
        (self.path / RUN).write_text("\n".join(lines) + "\n")

    def put_time(self, change):
        """Time is the first column."""
        rows = [r.split(",", 1) for r in self.rows]
        self.put(
            f"{change(i, time)},{others}"
            for i, (time, others) in enumerate(rows)
        )

    def errors(self):
        with warnings.catch_warnings(), time_limit(5.0):
            warnings.simplefilter("error")
            found = CheckCampaign(self.path)
        return [str(p) for p in found if p.severity == "error"]

    def assert_error(self, *words):
        errors = self.errors()
        good = [e for e in errors if all(word in e for word in words)]
        self.assertTrue(good, errors)
        with self.assertRaises(CampaignError) as caught:
            LoadCampaign(self.path)
        self.assertNotIn("\n", str(caught.exception))

    def test_one_time_that_is_none(self):
        for value, shown in (
            ("inf", "inf"),
            ("-inf", "-inf"),
            ("1e308", "1e+308"),
            ("-1e308", "-1e+308"),
            ("1e999", "inf"),
            ("1e12", "1e+12"),
        ):
            for place in (0, 6, len(self.rows) - 1):
                with self.subTest(value=value, row=place + 1):
                    self.put_time(
                        lambda i, t, p=place, v=value: v if i == p else t
                    )
                    self.assert_error(f"row {place + 1} ", "time_s", shown)

    def test_one_far_jump(self):
        self.put_time(lambda i, t: t if i < 200 else float(t) + 9e4)
        self.assert_error("row 201 ", "time_s", "9e+04 s before this row")

    def test_all_times_are_far_off(self):
        for change, word in (
            (lambda i, t: 5e-324 * i, "a step of 4.94066e-324 s"),
            (lambda i, t: 1e-310 * (i + 1), "a step of 1e-310 s"),
            (lambda i, t: 1e300 * i, "1e+300"),
            (lambda i, t: (-1) ** i * 1.7e308, "1.7e+308"),
            (lambda i, t: "nan", "nan"),
            (lambda i, t: "", "empty"),
            (lambda i, t: "0x1p3", "'0x1p3' is not a number"),
            (lambda i, t: "1_0", "'1_0' is not a number"),
            (lambda i, t: 0, "does not increase"),
        ):
            with self.subTest(word):
                self.put_time(change)
                self.assert_error("time_s", word)

    def test_values_beyond_all_others(self):
        for value in ("1e308", "-1.7e308", "inf", "1e20"):
            fields = self.rows[9].split(",")
            row = ",".join([fields[0], *[value] * (len(fields) - 1)])
            self.put([*self.rows[:9], row, *self.rows[10:]])
            self.assert_error("row 10 ", "leg1_length_m")

    def test_a_few_rows_are_no_run(self):
        for rows in (1, 2, 3, 9):
            self.put(self.rows[:rows])
            self.assert_error(RUN, f"{rows} data row", "10 or more")

    def test_columns_cost_no_more_than_their_text(self):
        names = ",".join(f"c{i}" for i in range(60_000))
        rows = self.rows[:20]
        for header, fields, word in (
            (names, "1.5", "23 missing columns"),
            (names, "x", "23 missing columns"),
            (f"{self.header},{names}", "1.5", None),
            (f"{self.header},{names}", "word", None),
            (f"{self.header},{names}", "", None),
            (f"{self.header}{',c' * 60_000}", "1", "60000 times"),
            (self.header + "," * 60_000, "1", "no name"),
        ):
            more = ",".join([fields] * 60_000)
            begins = header.startswith(self.header)
            self.put([f"{r},{more}" if begins else more for r in rows], header)
            with self.subTest(word):
                if word is None:
                    self.assertEqual(self.errors(), [])
                else:
                    self.assert_error(RUN, word)

    def test_memory_follows_the_text(self):
        self.put(["1"] * 1_000_000, ",".join(f"time_s{i}" for i in range(999)))
        self.assert_error(RUN, "fields")
        longest = [*self.rows[1:], f"{'9' * 3_000_000}{self.rows[0]}"]
        self.put(longest)
        self.assert_error(RUN, "time_s")

    def test_runs_that_are_no_files(self):
        path = self.path / RUN
        path.unlink()
        os.mkfifo(path)
        self.assert_error(RUN, "is a pipe")
        path.unlink()
        path.symlink_to("/dev/zero")
        self.assert_error(RUN, "is a device")
        path.unlink()
        path.mkdir()
        self.assert_error(RUN, "is a folder")
        shutil.rmtree(path)
        manifest = self.path / "campaign.yaml"
        manifest.unlink()
        os.mkfifo(manifest)
        self.assert_error("campaign.yaml", "is a pipe")

    def test_names_that_a_terminal_would_obey(self):
        manifest = self.path / "campaign.yaml"
        text = manifest.read_text()
        for name in (r"\e[31m.csv", r"\ud800.csv", r"a\u202eb.csv", r"\r"):
            manifest.write_text(text.replace(RUN, f'"{name}"', 1))
            for error in self.errors():
                self.assertTrue(error.isprintable(), error)
            self.assertTrue(self.errors())
        self.put(self.rows, self.header.replace("leg1_", "\x1b[31mleg1_"))
        manifest.write_text(text)
        for error in self.errors():
            self.assertTrue(error.isprintable(), error)


if __name__ == "__main__":
    unittest.main()

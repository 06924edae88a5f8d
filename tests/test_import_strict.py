"""What is no number, no scenario or no run is refused before it is written."""

import json
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import CampaignError
from brace_drake.core.resources import scenario_path
from brace_drake.recording.importing.mapped import ImportCampaign
from brace_drake.recording.importing.mcap_file import LoadMcapCampaign
from brace_drake.recording.importing.tables import LoadTable
from tests.commands import run_command

try:
    import openpyxl
except ImportError:
    openpyxl = None
try:
    from mcap.writer import Writer
except ImportError:
    Writer = None

MAP = {
    "format": "brace-import/1",
    "device": "pad bench",
    "columns": {"time_s": "t", "displacement_m": "x", "force_N": "f"},
}
RATE, COUNT = 100.0, 200
MANIFEST = {
    "format": "brace-campaign/1",
    "device": "pad bench",
    "rate_hz": RATE,
    "runs": [
        {"file": "a.csv", "contact": True, "motion": "m", "split": "fit"},
    ],
}
WORDS = ("OVERLOAD", "1,5", "--", "#DIV/0!", "true", "nan?")
GAPS = ("", " ", "nan", "NaN", "NA", "n/a", "#N/A", "null", "None")


class StrictTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.out = self.folder / "out"
        self.samples = [
            {"t": i / RATE, "x": 1e-3 * math.sin(i / 9), "f": i % 7}
            for i in range(COUNT)
        ]

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def write_table(self, name):
        rows = [";".join(map(str, s.values())) for s in self.samples]
        self.write(name, "\n".join(["t;x;f", *rows]))

    def write_map(self, file, **changes):
        runs = [{"file": file, "split": "fit"}]
        content = {**MAP, "runs": runs, **changes}
        if file.endswith(".csv"):
            content["options"] = {"delimiter": ";"}
        self.write("map.yaml", yaml.safe_dump(content))
        return self.folder / "map.yaml"

    def name_channels(self):
        """Samples as a campaign's own."""
        names = {"t": "time_s", "x": "displacement_m", "f": "force_N"}
        self.samples = [
            {names[k]: v for k, v in s.items()} for s in self.samples
        ]

    def write_mcap(self, **metadata):
        with (self.folder / "a.mcap").open("wb") as file:
            writer = Writer(file)
            writer.start()
            manifest = yaml.safe_dump(MANIFEST)
            writer.add_metadata(
                "brace_campaign", {"campaign.yaml": manifest, **metadata}
            )
            topic = writer.register_channel("/a", "json", 0)
            # As they were sent, the last one first.
            for i, sample in reversed(list(enumerate(self.samples))):
                data = json.dumps(sample).encode()
                writer.add_message(topic, 10**7 * i, data, 10**7 * i)
            writer.finish()

    def refuse(self, path, *words):
        """Nothing is written, and one line on standard error says why."""
        status, _, errors = run_command("import", path, "--out", self.out)
        self.assertEqual((status, errors.count("\n")), (2, 1), errors)
        for word in words:
            self.assertIn(word, errors)
        self.assertFalse(self.out.exists())


class TestWords(StrictTest):
    def test_a_word_of_a_text_is_refused_with_row_and_column(self):
        for word in WORDS:
            with self.subTest(word):
                self.samples[4]["f"] = self.samples[9]["f"] = word
                self.write_table("a.csv")
                place = "a.csv: row 5: column 'f' is the text "
                self.refuse(self.write_map("a.csv"), place + repr(word))

    def test_a_word_among_gaps_is_found(self):
        self.samples[2]["f"], self.samples[6]["f"] = "NA", "OVERLOAD"
        self.write_table("a.csv")
        self.refuse(self.write_map("a.csv"), "row 7: column 'f'", "OVERLOAD")

    def test_a_point_beside_a_decimal_comma_is_refused_as_it_is_written(self):
        rows = [f"{i / 100};{i};{i}".replace(".", ",") for i in range(50)]
        rows[8] = "0,08;8;1.234"
        self.write("a.csv", "\n".join(["t;x;f", *rows]))
        path = self.write_map("a.csv")
        text = path.read_text().replace("delimiter:", "decimal: ','\n  $:")
        path.write_text(text.replace("$", "delimiter"))
        self.refuse(path, "row 9: column 'f' is the text '1.234'")

    def test_a_usual_word_for_missing_is_a_gap_in_text_and_json(self):
        for i, gap in enumerate(GAPS):
            self.samples[3 * i]["f"] = gap
        self.write_table("a.csv")
        self.write("a.json", json.dumps(self.samples))
        wanted = np.arange(COUNT) % 7.0
        wanted[np.arange(0, 3 * len(GAPS), 3)] = np.nan
        for file in ("a.csv", "a.json"):
            with self.subTest(file):
                (run,) = ImportCampaign(self.write_map(file)).runs
                np.testing.assert_array_equal(run.channels["force_N"], wanted)

    def test_what_no_channel_is_taken_from_may_hold_words(self):
        for i, sample in enumerate(self.samples):
            sample["note"] = "ok" if i % 2 else i
        self.write_table("a.csv")
        text = (self.folder / "a.csv").read_text()
        self.write("a.csv", text.replace("t;x;f", "t;x;f;note"))
        (run,) = ImportCampaign(self.write_map("a.csv")).runs
        self.assertEqual(len(run.time_s), COUNT)

    def test_a_column_of_words_alone_is_not_called_absent(self):
        for sample in self.samples:
            sample["f"] = "off"
        self.write_table("a.csv")
        self.refuse(self.write_map("a.csv"), "row 1: column 'f'", "'off'")

    def test_json_refuses_what_is_no_number(self):
        for value, words in (
            *(("1.5", "the text '1.5'"), (True, "TRUE")),
            *(("OVERLOAD", "the text 'OVERLOAD'"),),
        ):
            self.samples[4]["f"] = value
            self.write("a.json", json.dumps(self.samples))
            self.write("a.jsonl", "\n".join(map(json.dumps, self.samples)))
            columns = {k: [s[k] for s in self.samples] for k in "txf"}
            self.write("b.json", json.dumps(columns))
            for file in ("a.json", "a.jsonl", "b.json"):
                with self.subTest(file, value=value):
                    place = f"{file}: row 5: column 'f' is {words}"
                    self.refuse(self.write_map(file), place)

    @unittest.skipIf(openpyxl is None, "openpyxl is not installed")
    def test_excel_refuses_what_is_no_number(self):
        for value, words in (
            ("#DIV/0!", "the text '#DIV/0!'"),
            ("1,5", "the text '1,5'"),
            (True, "TRUE"),
            ("=A2*2", "the text '=A2*2 (a formula, its value"),
        ):
            with self.subTest(value):
                self.samples[4]["f"] = value
                self.write_excel()
                place = f"a.xlsx: row 5: column 'f' is {words}"
                self.refuse(self.write_map("a.xlsx"), place)

    @unittest.skipIf(openpyxl is None, "openpyxl is not installed")
    def test_an_empty_cell_of_excel_is_a_gap(self):
        self.samples[4]["f"], self.samples[5]["f"] = None, "#N/A"
        self.write_excel()
        table = LoadTable(self.folder / "a.xlsx", {})
        self.assertEqual(np.flatnonzero(np.isnan(table["f"])).tolist(), [4, 5])
        self.assertEqual(table.words, {})

    @unittest.skipIf(openpyxl is None, "openpyxl is not installed")
    def test_advice_on_a_title_is_that_of_the_format(self):
        self.write_excel(["Test 3 of Monday"])
        path = self.write_map("a.xlsx")
        there = "no column 'x'; there are 'Test 3 of Monday'; "
        self.refuse(path, there + "options.skip_lines", "which sheet")
        for sample in self.samples:
            sample["t"] = "x"
        self.write_excel(["Test 3 of Monday"])
        with self.assertRaisesRegex(CampaignError, "skip_lines") as caught:
            LoadTable(self.folder / "a.xlsx", {})
        self.assertNotIn("delimiter", str(caught.exception))
        self.write("a.json", '{"a": ["x"]}')
        with self.assertRaisesRegex(CampaignError, "there; options.group says"):
            LoadTable(self.folder / "a.json", {})

    def write_excel(self, *above):
        book = openpyxl.Workbook()
        for row in (*above, list(self.samples[0])):
            book.active.append(row)
        for sample in self.samples:
            book.active.append(list(sample.values()))
        book.save(self.folder / "a.xlsx")

    @unittest.skipIf(Writer is None, "mcap is not installed")
    def test_mcap_refuses_words_with_and_without_a_map(self):
        self.samples[4]["f"] = "OVERLOAD"
        self.write_mcap()
        place = "row 5: column 'f' is the text 'OVERLOAD'"
        self.refuse(self.write_map("a.mcap"), place)
        self.name_channels()
        self.write_mcap()
        place = "topic /a: row 5: column 'force_N' is the text 'OVERLOAD'"
        self.refuse(self.folder / "a.mcap", place)

    @unittest.skipIf(Writer is None, "mcap is not installed")
    def test_a_column_of_remarks_stops_no_export(self):
        self.name_channels()
        for sample in self.samples:
            sample["note"] = "ok"
        self.write_table("a.csv")
        text = (self.folder / "a.csv").read_text().replace(";", ",")
        header = ",".join(self.samples[0])
        self.write("a.csv", text.replace("t,x,f", header) + "\n")
        self.write("campaign.yaml", yaml.safe_dump(MANIFEST))
        file = self.folder / "a.mcap"
        status, _, errors = run_command("export", self.folder, "--out", file)
        self.assertEqual(status, 0, errors)
        (run,) = LoadMcapCampaign(file).runs
        self.assertNotIn("note", run.channels)
        np.testing.assert_array_equal(
            run.channels["force_N"], np.arange(COUNT) % 7.0
        )

    @unittest.skipIf(Writer is None, "mcap is not installed")
    def test_a_scenario_that_an_mcap_file_has_not_is_told(self):
        self.name_channels()
        manifest = yaml.safe_dump({**MANIFEST, "scenario": "own.yaml"})
        self.write_mcap(**{"campaign.yaml": manifest})
        with self.assertRaisesRegex(CampaignError, "own.yaml is not there"):
            LoadMcapCampaign(self.folder / "a.mcap")


class TestScenario(StrictTest):
    def setUp(self):
        super().setUp()
        self.write_table("a.csv")

    def test_a_file_outside_the_maps_folder_is_refused(self):
        secret = self.folder.parent / f"{self.folder.name}.secret.yaml"
        secret.write_text("device: pad bench\n")
        self.addCleanup(secret.unlink)
        (self.folder / "link.yaml").symlink_to(secret)
        for name in (
            *("/etc/passwd", str(self.folder / "a.csv"), "link.yaml"),
            *(f"../{secret.name}", "x/../../etc/passwd", "."),
        ):
            with self.subTest(name):
                path = self.write_map("a.csv", scenario=name)
                self.refuse(path, "map.yaml: scenario is ", "allowed: a path")

    def test_a_file_that_is_no_scenario_is_refused(self):
        self.write("words.yaml", "root:x:0:0:root:/root:/bin/sh\n")
        self.write("key.yaml", "device: pad bench\ntorsoo: 3\n")
        for name, words in (
            ("a.csv", "a.csv: must hold a mapping"),
            ("words.yaml", "words.yaml: must hold a mapping"),
            ("key.yaml", "key.yaml: torsoo: no such key"),
            ("none.yaml", "scenario: none.yaml: cannot be read"),
        ):
            with self.subTest(name):
                self.refuse(self.write_map("a.csv", scenario=name), words)

    def test_a_scenario_in_the_maps_folder_goes_with_the_campaign(self):
        text = scenario_path("pad_bench.scenario.yaml").read_text()
        (self.folder / "machines").mkdir()
        self.write("machines/own.yaml", text)
        path = self.write_map("a.csv", scenario="machines/own.yaml")
        status, _, errors = run_command("import", path, "--out", self.out)
        self.assertEqual(status, 0, errors)
        self.assertEqual((self.out / "own.yaml").read_text(), text)


class TestRows(StrictTest):
    def test_a_rate_at_which_a_run_has_too_few_rows_is_refused(self):
        self.write_table("a.csv")
        # 1.99 s.
        for rate, rows in ((0.001, "1 row"), (0.5, "1 row"), (4.0, "8 rows")):
            with self.subTest(rate):
                path = self.write_map("a.csv", rate_hz=rate)
                words = f"{rate:g} Hz (rate_hz) are {rows}; allowed: 10 or more"
                self.refuse(path, "a.csv: 1.99 s at ", words)
        (run,) = ImportCampaign(self.write_map("a.csv", rate_hz=5.0)).runs
        self.assertEqual(len(run.time_s), 10)

    def test_a_file_of_too_few_rows_is_refused(self):
        del self.samples[9:]
        self.write_table("a.csv")
        self.refuse(self.write_map("a.csv"), "9 rows; allowed: 10 or more")

    @unittest.skipIf(Writer is None, "mcap is not installed")
    def test_a_topic_of_too_few_rows_is_refused(self):
        self.name_channels()
        del self.samples[9:]
        self.write_mcap()
        path = self.folder / "a.mcap"
        self.refuse(path, "a.csv: it has 9 rows; allowed: 10 or more")

    def test_a_part_of_too_few_rows_is_left_out(self):
        for sample in self.samples[120:]:
            sample["t"] += 5.0
        self.write_table("a.csv")
        # Parts last 1.19 s and 0.79 s.
        changes = {"gaps": "split", "rate_hz": 10.0}
        (run,) = ImportCampaign(self.write_map("a.csv", **changes)).runs
        self.assertEqual(len(run.time_s), 12)
        changes["rate_hz"] = 8.0
        (run,) = ImportCampaign(self.write_map("a.csv", **changes)).runs
        self.assertEqual(len(run.time_s), 10)
        changes["rate_hz"] = 7.0
        self.refuse(self.write_map("a.csv", **changes), "no part of 1 s and 10")


class TestDate(StrictTest):
    def test_when_it_was_recorded_goes_with_the_campaign(self):
        self.write_table("a.csv")
        self.refuse(self.write_map("a.csv", recorded="soon"), "recorded")
        path = self.write_map("a.csv", recorded="2026-11-20")
        status, _, errors = run_command("import", path, "--out", self.out)
        self.assertEqual(status, 0, errors)
        head = yaml.safe_load((self.out / "campaign.yaml").read_text())
        self.assertEqual(str(head["recorded"]), "2026-11-20")
        # Times of 1/100 s give a rate without digits of rounding.
        self.assertEqual(head["rate_hz"], RATE)


class TestLines(StrictTest):
    def test_a_fault_in_a_line_of_json_is_told_with_its_line(self):
        lines = ["", *map(json.dumps, self.samples)]
        good = lines[-1]
        for last, words in (
            (good[:20], "line 201: not JSON: "),
            ("[1, ", "line 201: not JSON: Expecting value: column 5"),
            (good + good, "line 201: not JSON: Extra data: column"),
            ('{"t": 1, "t": 2}', "line 201: not JSON: key 't' is there twice"),
            ('{"t": Infinity}', "line 201: not JSON: Infinity"),
        ):
            with self.subTest(last):
                self.write("a.jsonl", "\n".join([*lines[:-1], last]))
                with self.assertRaises(CampaignError) as caught:
                    LoadTable(self.folder / "a.jsonl", {})
                self.assertIn(f"a.jsonl: {words}", str(caught.exception))
                self.assertNotIn("line 1 ", str(caught.exception))

    def test_halves_of_two_lines_are_no_sample(self):
        lines = list(map(json.dumps, self.samples))
        lines[5:6] = ['{"t": 0.05, "x": 0.001', '"f": 5}']
        self.write("a.jsonl", "\n".join(lines))
        with self.assertRaisesRegex(CampaignError, "line 6: not JSON"):
            LoadTable(self.folder / "a.jsonl", {})


if __name__ == "__main__":
    unittest.main()

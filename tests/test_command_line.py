"""Bad input on the command line: one clear line, status 2, nothing written."""

import argparse
import contextlib
import csv
import io
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from brace_drake.cli.main import main, make_parser
from brace_drake.cli.options import load_motion, names_file
from tests.commands import run_command
from tests.shared_data import EXAMPLE


def commands(parser=None, above=""):
    """Names and parsers of all commands, and of their parts."""
    for action in (parser or make_parser())._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield above + name, command
                yield from commands(command, f"{above}{name} ")


class TestStart(unittest.TestCase):
    def test_help_and_a_misspelt_word_wait_for_nothing_slow(self):
        # In a new environment the laws alone compile for a minute.
        code = (
            "import sys; from brace_drake.cli.main import make_parser;"
            "make_parser(); print([n for n in ('numba', 'pydrake', 'torch',"
            " 'matplotlib', 'brace_drake.laws') if n in sys.modules])"
        )
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=Path(__file__).resolve().parents[1],
            capture_output=True,
            text=True,
        )
        self.assertEqual(done.stdout, "[]\n", done.stderr)

    def test_without_arguments_it_prints_the_commands(self):
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            with self.assertRaises(SystemExit) as caught:
                main([])
        self.assertEqual(caught.exception.code, 0)
        for name, _ in commands():
            self.assertIn(name.split()[0], text.getvalue())


class TestBadInput(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.campaign = self.folder / "campaign"
        self.out = self.folder / "out"
        shutil.copytree(EXAMPLE, self.campaign)

    def assert_refused(self, *words):
        for command in ("diagnose", "fit"):
            status, _, errors = run_command(
                command, self.campaign, "--out", self.out
            )
            self.assertEqual(status, 2, errors)
            self.assertEqual(len(errors.strip().splitlines()), 1, errors)
            self.assertNotIn("Traceback", errors)
            for word in words:
                self.assertIn(word, errors)
            self.assertFalse(self.out.exists())

    def test_a_folder_that_is_not_there(self):
        shutil.rmtree(self.campaign)
        self.assert_refused("campaign")

    def test_an_empty_folder(self):
        shutil.rmtree(self.campaign)
        self.campaign.mkdir()
        self.assert_refused("empty")

    def test_an_unreadable_yaml(self):
        (self.campaign / "campaign.yaml").write_text("format: [a\n")
        self.assert_refused("campaign.yaml")

    def test_a_wrong_format(self):
        path = self.campaign / "campaign.yaml"
        path.write_text(path.read_text().replace("campaign/1", "campaign/9"))
        self.assert_refused("brace-campaign/9", "brace-campaign/1")

    def test_a_file_cut_in_the_middle(self):
        path = self.campaign / "push.csv"
        path.write_bytes(path.read_bytes()[:100_000])
        self.assert_refused("push.csv", "row")

    def test_a_missing_column(self):
        path = self.campaign / "push.csv"
        text = path.read_text()
        path.write_text(text.replace("leg1_length_m", "leg1_length_mm", 1))
        self.assert_refused("push.csv", "leg1_length_m")

    def test_an_infinite_value(self):
        path = self.campaign / "push.csv"
        lines = path.read_text().splitlines()
        fields = lines[12].split(",")
        fields[3] = "inf"
        lines[12] = ",".join(fields)
        path.write_text("\n".join(lines) + "\n")
        self.assert_refused("push.csv", "row 12", "leg3_force_command_N")

    def test_a_device_that_has_no_twin_yet(self):
        path = self.campaign / "campaign.yaml"
        path.write_text(path.read_text().replace("bench stage 2", "gantry"))
        self.assert_refused("gantry")

    def test_a_place_that_cannot_be_written(self):
        place = self.folder / "file"
        place.write_text("")
        for command in ("diagnose", "fit"):
            status, _, errors = run_command(
                command, self.campaign, "--out", place / "out"
            )
            self.assertEqual(status, 2)
            self.assertIn("cannot write", errors)
            self.assertEqual(len(errors.strip().splitlines()), 1)

    def test_a_scenario_that_is_not_there(self):
        status, _, errors = run_command(
            "diagnose",
            self.campaign,
            "--out",
            self.out,
            "--scenario",
            self.folder / "no.yaml",
        )
        self.assertEqual(status, 2)
        self.assertIn("no.yaml", errors)

    def test_a_scenario_with_nothing_in_it(self):
        place = self.folder / "blank.yaml"
        place.write_text("# written to a disk that was full\n")
        status, _, errors = run_command(
            "diagnose", self.campaign, "--out", self.out, "--scenario", place
        )
        self.assertEqual(status, 2)
        self.assertIn("blank.yaml", errors)
        self.assertIn("found nothing", errors)


class TestManyCampaigns(unittest.TestCase):
    """The diagnosis itself is left out: files and status are looked at."""

    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.out = self.folder / "out"
        self.campaigns = [self.folder / n for n in ("a", "b", "deep/a")]
        for campaign in self.campaigns:
            shutil.copytree(EXAMPLE, campaign)

    def diagnose(self, *campaigns):
        def fake(campaign, scenario, diagram, out, args):
            (out / "report.html").write_text("")
            document = {
                "verdict": {
                    "gap": True,
                    "effects": ["relaxation"],
                    "blocks": ["contact"],
                    "outside_library": False,
                    "ambiguous_with": [],
                    "probability": 0.97,
                    "sentence": "There is a gap.",
                },
                "shrink": {
                    "before": 3.0,
                    "after": 1.1,
                    "closed": 0.95,
                    "closed_interval": [0.9, 0.99],
                },
            }
            return document, []

        with mock.patch("brace_drake.cli.diagnosis.diagnose._Diagnose", fake):
            return run_command("diagnose", *campaigns, "--out", self.out)

    def table(self):
        with (self.out / "summary.csv").open() as file:
            return list(csv.DictReader(file))

    def test_each_has_its_folder_and_its_row(self):
        status, _, _ = self.diagnose(*self.campaigns)
        self.assertEqual(status, 0)
        rows = self.table()
        self.assertEqual([r["campaign"] for r in rows], ["a", "b", "a_2"])
        for row in rows:
            self.assertTrue((self.out / row["report"]).exists())
            self.assertEqual(row["effects"], "relaxation")
            self.assertEqual(float(row["closed"]), 0.95)
        page = (self.out / "summary.html").read_text()
        self.assertIn('href="a_2/report.html"', page)

    def test_one_that_fails_is_a_row_with_its_error(self):
        (self.campaigns[0] / "campaign.yaml").write_text("format: [a\n")
        status, _, errors = self.diagnose(*self.campaigns[:2])
        self.assertEqual(status, 2)
        self.assertNotIn("Traceback", errors)
        failed, good = self.table()
        self.assertEqual(failed["verdict"], "failed")
        self.assertIn("campaign.yaml", failed["error"])
        self.assertEqual(good["verdict"], "gap")
        page = (self.out / "summary.html").read_text()
        self.assertIn("campaign.yaml", page)

    def test_a_place_that_cannot_be_written_stops_at_once(self):
        self.out.write_text("")
        status, _, errors = self.diagnose(*self.campaigns[:2])
        self.assertEqual(status, 2)
        self.assertEqual(len(errors.strip().splitlines()), 1)


class TestHelp(unittest.TestCase):
    def test_every_command_has_an_example(self):
        for name, command in commands():
            with self.subTest(command=name):
                self.assertIn("example", command.format_help())

    def test_every_argument_is_explained_in_three_words_or_more(self):
        for name, command in commands():
            for action in command._actions:
                with self.subTest(command=name, argument=action.dest):
                    if isinstance(action, argparse._SubParsersAction):
                        continue
                    words = (action.help or "").split()
                    self.assertGreaterEqual(len(words), 3)
                    self.assertNotIn(words[0], ("of", "default:"))


class TestBadArguments(unittest.TestCase):
    """What the parser itself refuses, in one line."""

    def assert_refused(self, command, *words):
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors):
            with self.assertRaises(SystemExit) as caught:
                main([*map(str, command)])
        self.assertEqual(caught.exception.code, 2)
        text = errors.getvalue()
        self.assertEqual(text.count("\n"), 1, text)
        self.assertTrue(text.startswith("brace-drake: "), text)
        for word in words:
            self.assertIn(word, text)

    def test_no_seed_is_negative(self):
        seen = 0
        for name, command in commands():
            for action in command._actions:
                for option in action.option_strings:
                    if option.endswith("seed"):
                        seen += 1
                        with self.subTest(command=name, option=option):
                            self.assertEqual(action.type("0"), 0)
                            for bad in ("-1", "1.5", "one"):
                                with self.assertRaisesRegex(
                                    argparse.ArgumentTypeError, "at least 0"
                                ):
                                    action.type(bad)
        self.assertGreater(seen, 8)

    def test_one_line_names_the_argument_and_what_is_allowed(self):
        at = ("--port", "p", "--motion", "push", "--out", "o")
        for command, words in (
            (("fit", "c", "--seed", -1), ("--seed", "'-1'", "at least 0")),
            (("plan", "--jobs", "abc"), ("--jobs", "'abc'", "at least 1")),
            (("emulate", "--duration", -1), ("--duration", "above 0")),
            (("twin", "--port", "p", "--memory", "nan"), ("--memory", "nan")),
            (("record", *at, "--countdown", -1), ("--countdown", "'-1'")),
            (("fit", "c", "--out", ""), ("--out", "nothing is given")),
            (("fit",), ("CAMPAIGN", "brace-drake fit --help")),
            (("fitt",), ("'fitt'", "did you mean fit?")),
            (("withheld", "mak"), ("'mak'", "did you mean make?")),
            (
                ("fit", "c", "--scenaro", "x"),
                ("did you mean --scenario?", "brace-drake fit --help"),
            ),
            (("plan", "--effcts=a"), ("did you mean --effects?",)),
            (
                ("diagnose", "c", "--otu", "x"),
                ("required: --out", "no option --otu, did you mean --out?"),
            ),
            (("--versoin",), ("did you mean --version?",)),
            (("fit", "c", "d"), ("unrecognized arguments: d;",)),
            (("fit", "c", "--fix", "a=b"), ("'b' in 'a=b'", "not a number")),
            (("fit", "c", "--bounds", "a=3"), ("not NAME=LO:HI",)),
            (("plan", "--motions", ",,,"), ("',,,' names nothing", "allowed")),
            (("plan", "--effects", ""), ("'' names nothing", "allowed")),
            (("diagnose", "c", "--out", "o", "--without", " "), ("nothing",)),
            (("payoff", "--out", "o", "--force-limit", "nan"), ("above 0",)),
            (
                ("personalize", "s", "--out", "o", "--origin", "nan", 0, 0),
                ("--origin", "'nan' is not a number"),
            ),
            (("predict", "p", "--displacement-mm", "inf"), ("not a number",)),
        ):
            with self.subTest(command=command):
                self.assert_refused(command, *words)

    def test_every_whole_number_has_a_largest_that_is_told(self):
        huge, seen = "9" * 30, 0
        for name, command in commands():
            for action in command._actions:
                with contextlib.suppress(argparse.ArgumentTypeError, TypeError):
                    if action.type is None or action.type("1") != 1:
                        continue
                    if not isinstance(action.type("1"), int):
                        continue
                    seen += 1
                    with self.subTest(command=name, option=action.dest):
                        with self.assertRaisesRegex(
                            argparse.ArgumentTypeError, "at most [1-9]"
                        ):
                            action.type(huge)
        self.assertGreater(seen, 30)

    def test_predict_names_the_factors_of_a_subject(self):
        from brace_drake.learning.subjects import FACTORS

        text = dict(commands())["predict"].epilog
        for name in FACTORS:
            self.assertIn(name, text)


class TestWithoutTheSource(unittest.TestCase):
    def test_validate_asks_for_a_campaign_where_no_example_is(self):
        nowhere = mock.patch(
            "brace_drake.core.resources.example_campaign_path",
            return_value=Path("/nowhere/example"),
        )
        with tempfile.TemporaryDirectory() as folder, nowhere:
            out = Path(folder) / "out"
            status, _, errors = run_command("validate", "--out", out)
            self.assertEqual((status, errors.count("\n")), (2, 1))
            self.assertIn("name a campaign", errors)
            self.assertFalse(out.exists())


class TestMotions(unittest.TestCase):
    def test_a_folder_of_a_motions_name_is_no_reference(self):
        with tempfile.TemporaryDirectory() as folder:
            with contextlib.chdir(folder):
                Path("push").mkdir()
                self.assertEqual(load_motion("push").file, "push.csv")
                self.assertFalse(names_file("push"))
                Path("reversal").write_text("time_s\n")
                self.assertTrue(names_file("reversal"))


if __name__ == "__main__":
    unittest.main()

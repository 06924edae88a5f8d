"""Making and answering withheld cases, file by file."""

import json
import signal
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
import yaml

from brace_drake.recording import CheckCampaign, LoadCampaign
from brace_drake.withheld.answer import answer_cases
from brace_drake.withheld.make import make_cases
from brace_drake.withheld.seals import (
    COMMITMENT,
    SEALS,
    AnswerError,
    check_seal,
)
from tests.commands import run_command

VERDICT = {
    "gap": False,
    "effects": [],
    "outside_library": False,
    "blocks": [],
    "probability": 0.9,
}


class TestMake(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.cases = folder / "cases"
        cls.vault = folder / "vault" / "truth.json"
        # With nothing wrong: only its background has to be measured.
        cls.status, _, cls.errors = run_command(
            *("withheld", "make", "--cases", 1, "--seed", 18),
            *("--out", cls.cases, "--vault", cls.vault),
        )

    def test_a_made_case_is_a_sound_campaign_without_its_truth(self):
        self.assertEqual(self.status, 0, self.errors)
        case = self.cases / "case000"
        errors = [p for p in CheckCampaign(case) if p.severity == "error"]
        self.assertEqual(errors, [])
        campaign = LoadCampaign(case)
        self.assertEqual(len(campaign.runs), 10)
        self.assertEqual(len(campaign.split("validation")), 2)
        names = {p.name for p in case.iterdir()}
        runs = {r.file for r in campaign.runs}
        self.assertEqual(names, {"campaign.yaml", *runs})

    def test_the_vault_keeps_what_the_seal_promises(self):
        kept = json.loads(self.vault.read_text())["cases"]["case000"]
        seals = yaml.safe_load((self.cases / SEALS).read_text())["seals"]
        check_seal("case000", kept["truth"], kept["salt"], seals["case000"])
        self.assertNotIn("within_tolerances", kept["truth"])
        background = kept["truth"]["floors"]["background"]
        # Every machine has its imperfections, but they must not show.
        self.assertGreater(background["rms"], 0.0)
        self.assertLess(background["rms"], 0.3)

    def test_cases_do_not_depend_on_how_many_are_made_at_a_time(self):
        def drawn(path, kind, rng, tolerances):
            number = int(rng.integers(10**9))
            return {"kind": kind, "number": number, "off": tolerances}

        truths = []
        for jobs in (1, 3):
            with (
                tempfile.TemporaryDirectory() as folder,
                mock.patch("brace_drake.withheld.make._make_case", drawn),
            ):
                vault = Path(folder) / "vault.json"
                make_cases(
                    Path(folder) / "cases",
                    vault,
                    7,
                    seed=1,
                    jobs=jobs,
                    tolerances=2.0,
                )
                kept = json.loads(vault.read_text())["cases"]
                truths.append({n: c["truth"] for n, c in kept.items()})
        self.assertEqual(len({t["number"] for t in truths[0].values()}), 7)
        self.assertEqual({t["off"] for t in truths[0].values()}, {2.0})
        self.assertEqual(truths[0], truths[1])

    def test_readings_come_in_steps_of_their_instruments(self):
        runs = LoadCampaign(self.cases / "case000").runs
        length = np.round(runs[3].channels["leg1_length_m"] / 1e-5, 3)
        np.testing.assert_array_equal(length, np.round(length))

    def test_nothing_is_overwritten(self):
        status, _, errors = run_command(
            *("withheld", "make", "--cases", 1),
            *("--out", self.cases, "--vault", self.vault),
        )
        self.assertEqual(status, 2)
        self.assertIn("exists already", errors)

    def test_the_vault_may_not_lie_among_the_cases(self):
        out = self.cases.parent / "others"
        status, _, errors = run_command(
            *("withheld", "make", "--cases", 1),
            *("--out", out, "--vault", out / "truth.json"),
        )
        self.assertEqual(status, 2)
        self.assertIn("outside", errors)
        self.assertFalse(out.exists())


class TestAnswer(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.cases = folder / "cases"
        self.answers = folder / "answers"
        for name in ("case000", "case001"):
            (self.cases / name).mkdir(parents=True)
            for file in ("campaign.yaml", "push.csv", "label.yaml"):
                (self.cases / name / file).write_text("x")
        seals = yaml.safe_dump({"seals": {"case000": "0", "case001": "1"}})
        (self.cases / SEALS).write_text(seals)

    def diagnose(self, command, folder):
        """Stands in for the process: notes what it is handed."""
        copy, out = Path(command[4]), Path(command[6])
        self.handed.append(sorted(p.name for p in copy.iterdir()))
        if self.fails:
            return 2, "brace-drake: no good\n", 1.0
        out.mkdir()
        (out / "diagnosis.json").write_text(
            json.dumps({"verdict": VERDICT, "shrink": {"closed": 0.5}})
        )
        return 0, "", 2.5

    def answer(self, fails=False):
        self.handed, self.fails = [], fails
        with mock.patch(
            "brace_drake.withheld.answer._Running.run",
            lambda _, command, folder: self.diagnose(command, folder),
        ):
            return answer_cases(self.cases, self.answers, jobs=2)

    def test_a_process_is_handed_the_recordings_only(self):
        found = self.answer()
        self.assertEqual(self.handed, [["campaign.yaml", "push.csv"]] * 2)
        self.assertEqual(found["case001"]["closed"], 0.5)
        self.assertEqual(found["case001"]["seconds"], 2.5)
        self.assertTrue((self.answers / "COMMITMENT").exists())

    def test_a_case_is_not_diagnosed_twice(self):
        first = self.answer()
        self.assertEqual(self.answer(), first)
        self.assertEqual(self.handed, [])

    def test_a_failure_is_an_answer_too_and_is_tried_again(self):
        found = self.answer(fails=True)["case000"]
        self.assertIsNone(found["verdict"])
        self.assertIn("no good", found["error"])
        self.answer()
        self.assertEqual(len(self.handed), 2)

    def test_answers_that_replace_others_do_not_hide_them(self):
        self.answer(fails=True)
        first = yaml.safe_load((self.answers / COMMITMENT).read_text())
        self.assertNotIn("earlier", first)
        self.answer()
        second = yaml.safe_load((self.answers / COMMITMENT).read_text())
        self.assertEqual(second["earlier"], [first])
        self.answer()
        third = yaml.safe_load((self.answers / COMMITMENT).read_text())
        self.assertEqual(third, second)

    def test_a_signal_ends_what_runs_and_begins_no_more(self):
        # A diagnosis that takes a minute, and notes that it has begun.
        slow = self.cases.parent / "slow"
        begun = self.cases.parent / "begun"
        slow.write_text(f"#!/bin/sh\necho >> {begun}\nexec sleep 60\n")
        slow.chmod(0o755)

        def interrupt(*_):
            raise KeyboardInterrupt

        before = signal.signal(signal.SIGALRM, interrupt)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        start = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, 2.0)
        with (
            mock.patch("brace_drake.withheld.answer.sys.executable", str(slow)),
            self.assertRaises(KeyboardInterrupt),
        ):
            answer_cases(self.cases, self.answers, jobs=1)
        self.assertLess(time.monotonic() - start, 30.0)
        self.assertEqual(begun.read_text(), "\n")
        self.assertFalse((self.answers / "answers.json").exists())

    def test_answers_to_other_cases_are_not_taken_for_these(self):
        self.answer()
        seals = yaml.safe_dump({"seals": {"case000": "2", "case001": "3"}})
        (self.cases / SEALS).write_text(seals)
        with self.assertRaisesRegex(AnswerError, "other cases"):
            self.answer()

    def test_a_folder_without_cases_is_refused(self):
        with self.assertRaisesRegex(AnswerError, SEALS):
            answer_cases(self.cases / "case000", self.answers)
        (self.cases / SEALS).write_text("seals: {case007: abc}")
        with self.assertRaisesRegex(AnswerError, "case007"):
            answer_cases(self.cases, self.answers)


if __name__ == "__main__":
    unittest.main()

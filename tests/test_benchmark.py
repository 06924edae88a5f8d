"""Frozen sets, answers of any method, and the table of methods."""

import json
import shutil
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import yaml

from brace_drake.withheld.benchmark import (
    BenchmarkError,
    check_set,
    digest_of_recordings,
    find_set,
    rms_of_recordings,
    set_names,
)
from brace_drake.withheld.plain_answers import PLAIN_FORMAT, read_plain
from brace_drake.withheld.score import load_judged, score
from brace_drake.withheld.seals import (
    SEALS,
    VAULT_FORMAT,
    AnswerError,
    new_salt,
    seal,
)
from tests.commands import run_command
from tests.test_withheld_score import truth


class TestFrozenSets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.status, cls.printed, cls.errors = run_command(
            *("withheld", "make", "--benchmark", "bench-tiny"),
            *("--out", cls.folder / "cases"),
            *("--vault", cls.folder / "vault.json", "--jobs", 1),
        )

    def copy(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        return shutil.copytree(self.folder / "cases", folder / "cases")

    def test_the_declaration_of_a_set_makes_its_recordings(self):
        self.assertEqual(self.status, 0, self.errors)
        self.assertIn("the recordings of the set", self.printed)
        frozen = find_set("bench-tiny")
        names = {p.name for p in (self.folder / "cases").glob("case*")}
        self.assertEqual(names, set(frozen.rms))
        vault = json.loads((self.folder / "vault.json").read_text())
        kinds = [c["truth"]["kind"] for c in vault["cases"].values()]
        self.assertEqual(kinds, ["single", "none"])

    def test_the_checksum_does_not_mind_a_last_digit(self):
        cases, frozen = self.copy(), find_set("bench-tiny")
        path = cases / "case000" / "push.csv"
        text = path.read_text().replace("0.14105000", "0.14106000", 1)
        path.write_text(text)
        self.assertNotEqual(digest_of_recordings(cases), frozen.sha256)
        self.assertIn("but for last digits", check_set(cases, frozen))

    def test_recordings_of_another_machine_are_refused(self):
        cases, frozen = self.copy(), find_set("bench-tiny")
        shutil.rmtree(cases / "case000")
        shutil.copytree(cases / "case001", cases / "case000")
        with self.assertRaisesRegex(BenchmarkError, "case000"):
            check_set(cases, frozen)
        path = cases / "case001" / "push.csv"
        path.write_text(path.read_text().replace(",", ";"))
        with self.assertRaisesRegex(AnswerError, "push.csv"):
            check_set(cases, frozen)

    def test_a_fault_a_tenth_as_large_is_another_recording(self):
        # 0.3 % of 6 N in one leg: what no eye sees.
        cases, frozen = self.copy(), find_set("bench-tiny")
        rms = dict(rms_of_recordings(cases))
        rms["case000"] = [1.003 * rms["case000"][1], *rms["case000"][1:]]
        with self.assertRaises(BenchmarkError):
            check_set(cases, replace(frozen, sha256="", rms=rms))

    def test_each_set_says_what_it_is(self):
        for name in set_names():
            with self.subTest(name=name):
                frozen = find_set(name)
                self.assertEqual(len(frozen.rms), frozen.cases)
                self.assertEqual(len(frozen.sha256), 64)
                self.assertTrue(frozen.title)

    def test_an_unknown_set_is_one_clear_line(self):
        for words, told in (
            (("--benchmark", "bench-cleen"), "did you mean bench-clean"),
            (("--benchmark", "bench-tiny", "--seed", 3), "of its own"),
        ):
            status, _, errors = run_command(
                *("withheld", "make", *words),
                *("--out", self.folder / "new"),
                *("--vault", self.folder / "new.json"),
            )
            self.assertEqual(status, 2)
            self.assertIn(told, errors)
            self.assertFalse((self.folder / "new").exists())


# Truth and a plain answer of six cases, as a third party would write it.
TABLE = (
    (truth("none", [], []), {"effects": [], "probability": 0.9}),
    (
        truth("none", [], []),
        {"effects": ["backlash"], "probability": 0.85, "seconds": 4.0},
    ),
    (
        truth("single", ["force_lag"], ["sensing"]),
        {"effects": ["force_lag"], "closed": 0.9, "seconds": 2.0},
    ),
    (
        truth("single", ["reflex"], ["torso"]),
        {"effects": ["hardening"], "probability": 0.7, "closed": 0.3},
    ),
    (
        truth("pair", ["ring_mass", "reflex"], ["mechanism", "torso"]),
        {"effects": ["reflex", "ring_mass"], "closed": 0.8, "seconds": 3.0},
    ),
    (
        truth("outside", ["tremor"], ["torso"]),
        {"effects": [], "outside": True, "blocks": ["torso"]},
    ),
)


class TestPlainAnswers(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        truths, seals, self.given = {}, {}, {}
        for i, (true, told) in enumerate(TABLE):
            name, salt = f"case{i:03d}", new_salt()
            truths[name] = {"salt": salt, "truth": true}
            seals[name] = seal(true, salt)
            self.given[name] = told
        self.vault = self.folder / "vault.json"
        self.vault.write_text(
            json.dumps({"format": VAULT_FORMAT, "cases": truths})
        )
        (self.folder / SEALS).write_text(yaml.safe_dump({"seals": seals}))

    def write(self, cases, method="mine"):
        path = self.folder / f"{method}.json"
        document = {"format": PLAIN_FORMAT, "method": method, "cases": cases}
        path.write_text(json.dumps(document))
        return path

    def test_the_score_is_what_hands_have_counted(self):
        path = self.write(self.given)
        found = score(load_judged(self.folder, self.vault, path), least=0.3)
        counts = {
            name: (s["hits"], s["count"]) for name, s in found["shares"].items()
        }
        self.assertEqual(counts["answered right"], (4, 6))
        self.assertEqual(counts["effects: exactly those at fault"], (2, 3))
        self.assertEqual(counts["blocks: exactly those at fault"], (3, 4))
        self.assertEqual(counts["no gap where there is none"], (1, 2))
        self.assertEqual(counts["wrong names with p above 0.8"], (1, 6))
        self.assertEqual(counts["gap closed by 80 % or more"], (2, 4))
        self.assertEqual(counts["outside: recall"], (1, 1))
        self.assertEqual(found["closed_median"], 0.8)
        self.assertEqual(found["seconds_median"], 3.0)

    def test_a_method_without_names_is_scored_for_how_far_alone(self):
        rows = {n: {"effects": None, "closed": 0.5} for n in self.given}
        rows["case000"] = {"effects": []}
        path = self.write(rows)
        found = score(load_judged(self.folder, self.vault, path), least=0.3)
        shares = found["shares"]
        self.assertEqual(shares["effects: exactly those at fault"]["count"], 0)
        self.assertEqual(shares["outside: recall"]["count"], 0)
        self.assertEqual(shares["no gap where there is none"]["hits"], 1)
        self.assertEqual(found["closed_median"], 0.5)

    def test_the_table_has_a_row_for_each_method(self):
        files = [self.write(self.given, m) for m in ("mine", "yours")]
        status, printed, errors = run_command(
            *("withheld", "table", self.folder, "--vault", self.vault),
            *("--answers", *files),
        )
        self.assertEqual(status, 0, errors)
        rows = printed.splitlines()
        self.assertEqual(len(rows), 4)
        # Wilson's interval of 2 of 3 is 0.208 to 0.939.
        self.assertIn("| mine | 2 of 3 (21 to 94 %) |", rows[2])

    def test_what_no_method_can_answer_is_told_by_case_and_key(self):
        for row, words in (
            ({"effects": ["backlsh"]}, "case000: effects: no 'backlsh', did"),
            ({"effects": [], "probability": 1.2}, "probability is 1.2"),
            ({"effects": [], "closed": "much"}, "closed is 'much'"),
            ({"effects": [], "outside": 1}, "outside is 1"),
            ({"effects": "backlash"}, "not a list"),
            ({"efects": []}, "no key 'efects', did you mean effects"),
            ({}, "neither effects nor outside"),
            ([], "not a map"),
        ):
            path = self.write({**self.given, "case000": row})
            with (
                self.subTest(row=row),
                self.assertRaisesRegex(AnswerError, words),
            ):
                read_plain(path)

    def test_cases_that_are_missing_are_refused(self):
        path = self.write({"case000": self.given["case000"]})
        status, _, errors = run_command(
            *("withheld", "score", self.folder, "--vault", self.vault),
            *("--answers", path),
        )
        self.assertEqual(status, 2)
        self.assertIn("not the cases", errors)


if __name__ == "__main__":
    unittest.main()

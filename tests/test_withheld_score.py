"""Seals, commitments and scores of withheld cases, worked out by hand."""

import json
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np
import yaml

from brace_drake.withheld.cases import KINDS, build_case, draw_kinds
from brace_drake.withheld.faults import FAULTS
from brace_drake.withheld.judged import Judged, label
from brace_drake.withheld.score import load_judged, score, share_of
from brace_drake.withheld.score_text import draw_reliability, format_score
from brace_drake.withheld.seals import (
    SEALS,
    VAULT_FORMAT,
    AnswerError,
    SealError,
    check_seal,
    commit,
    new_salt,
    seal,
)
from tests.commands import run_command


def truth(kind, effects, blocks, severity="small", floors=1.0, beside=()):
    """A truth as `make` seals it; `beside`: floors of each beside the other."""
    outside = kind == "outside"
    floors = {"faults": None if kind == "none" else {"refitted": floors}}
    if beside:
        pairs = zip(effects, beside, strict=True)
        floors["beside"] = {name: {"refitted": size} for name, size in pairs}
    return {
        "kind": kind,
        "severity": None if kind == "none" else severity,
        "effects": [] if outside else effects,
        "outside": effects if outside else [],
        "blocks": blocks,
        "floors": floors,
    }


def verdict(effects=(), blocks=(), outside=False, rivals=(), p=0.9):
    """A verdict as `diagnose` writes it."""
    return {
        "gap": bool(effects) or outside,
        "effects": list(effects),
        "blocks": list(blocks),
        "outside_library": outside,
        "ambiguous_with": list(rivals),
        "probability": p,
    }


# Truth, verdict and closed share of eight cases.
TABLE = (
    (truth("none", [], []), verdict(p=0.8), None),
    (truth("none", [], []), verdict(["backlash"], ["actuation"]), None),
    (
        truth("single", ["backlash"], ["actuation"]),
        verdict(["backlash"], ["actuation"]),
        0.9,
    ),
    (
        truth("single", ["force_lag"], ["sensing"], "large", 5.0),
        verdict(["hardening"], ["contact"], rivals=["force_lag"]),
        0.5,
    ),
    (
        truth("single", ["reflex"], ["torso"], "small", 0.1),
        verdict(p=0.6),
        None,
    ),
    (
        truth(
            "pair",
            ["ring_mass", "reflex"],
            ["mechanism", "torso"],
            beside=(4.0, 0.5),
        ),
        verdict(["reflex", "ring_mass"], ["torso", "mechanism"]),
        0.7,
    ),
    (
        truth(
            "pair",
            ["backlash", "reflex"],
            ["actuation", "torso"],
            beside=(4.0, 0.1),
        ),
        verdict(["backlash"], ["actuation"]),
        0.95,
    ),
    (
        truth("outside", ["tremor"], ["torso"]),
        verdict(outside=True, blocks=["torso"]),
        None,
    ),
)


class TestSeals(unittest.TestCase):
    def test_a_seal_holds_for_its_document_alone(self):
        salt = new_salt()
        promised = seal({"a": 1, "b": [2.5]}, salt)
        check_seal("case", {"b": [2.5], "a": 1}, salt, promised)
        with self.assertRaisesRegex(SealError, "case"):
            check_seal("case", {"a": 1, "b": [2.6]}, salt, promised)
        with self.assertRaises(SealError):
            check_seal("case", {"a": 1, "b": [2.5]}, new_salt(), promised)

    def test_the_same_document_never_has_the_same_seal_twice(self):
        self.assertNotEqual(seal({}, new_salt()), seal({}, new_salt()))


class TestShares(unittest.TestCase):
    def test_the_interval_is_wilsons(self):
        # Newcombe, Statistics in Medicine 17, 1998, table I: 81 of 263 and
        # 15 of 148 without correction for continuity.
        for hits, count, low, high in (
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
        ):
            answers = [True] * hits + [False] * (count - hits)
            found = share_of(answers)["interval"]
            self.assertAlmostEqual(found[0], low, places=4)
            self.assertAlmostEqual(found[1], high, places=4)
        self.assertEqual(share_of([])["interval"], [0.0, 1.0])


class TestCases(unittest.TestCase):
    def test_kinds_come_in_their_shares(self):
        kinds = draw_kinds(np.random.default_rng(0), 50)
        counts = [kinds.count(k) for k in KINDS]
        self.assertEqual(counts, [10, 10, 10, 20])

    def test_a_case_is_its_faults_and_its_background(self):
        fault = next(f for f in FAULTS if f.name == "saturation")
        case = build_case(
            np.random.default_rng(0), "single", (fault,), "medium", lambda _: 8
        )
        self.assertAlmostEqual(case.flaws.legs.limit, 8 * fault.strengths[1])
        self.assertEqual(case.flaws.ring, case.background.ring)
        self.assertEqual(case.truth()["blocks"], ["actuation"])
        json.dumps(case.truth(), allow_nan=False)

    def test_a_pair_without_one_of_its_faults_is_the_other(self):
        names = ("viscous_leg", "posture_drift")
        pair = tuple(f for f in FAULTS if f.name in names)
        case = build_case(
            np.random.default_rng(0), "pair", pair, "small", lambda _: 8
        )
        drag, drift = pair
        self.assertEqual(case.without(drag).legs, case.background.legs)
        self.assertEqual(case.without(drag).torso, case.flaws.torso)
        self.assertEqual(case.without(drift).legs, case.flaws.legs)
        self.assertEqual(case.without(drift).torso, case.background.torso)


class WithFiles(unittest.TestCase):
    """A folder of seals, a vault and answers of TABLE."""

    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.vault = self.folder / "vault.json"
        self.answers = self.folder / "answers"
        self.answers.mkdir()
        truths, seals, given = {}, {}, {}
        for i, (true, told, closed) in enumerate(TABLE):
            name, salt = f"case{i:03d}", new_salt()
            truths[name] = {"salt": salt, "truth": true}
            seals[name] = seal(true, salt)
            given[name] = {"verdict": told, "closed": closed, "error": None}
        self.vault.write_text(
            json.dumps({"format": VAULT_FORMAT, "cases": truths})
        )
        (self.folder / SEALS).write_text(yaml.safe_dump({"seals": seals}))
        commit(self.folder, self.answers, given)

    def judged(self):
        return load_judged(self.folder, self.vault, self.answers)

    def run_score(self, *more):
        return run_command(
            *("withheld", "score", self.folder, "--vault", self.vault),
            *("--answers", self.answers, *more),
        )


class TestScore(WithFiles):
    def test_figures_of_a_made_up_table(self):
        found = score(self.judged(), least=0.3)
        counts = {
            name: (s["hits"], s["count"]) for name, s in found["shares"].items()
        }
        self.assertEqual(counts["answered right"], (4, 8))
        self.assertEqual(counts["false alarms"], (1, 2))
        self.assertEqual(counts["singles: first answer"], (1, 3))
        self.assertEqual(counts["detectable singles: first answer"], (1, 2))
        self.assertEqual(counts["detectable singles: coverage"], (2, 2))
        self.assertEqual(counts["pairs: both named"], (1, 2))
        self.assertEqual(counts["pairs, each detectable: both named"], (1, 1))
        self.assertEqual(counts["outside: recall"], (1, 1))
        self.assertEqual(counts["outside: precision"], (1, 1))
        self.assertEqual(counts["library effects called outside"], (0, 5))
        self.assertEqual(counts["blocks: exactly those at fault"], (3, 6))
        self.assertEqual(counts["detectable gaps: blocks at fault"], (4, 5))
        self.assertEqual(found["answers_per_case"], 1.5)
        self.assertAlmostEqual(found["gap_closed_median"], 0.8)
        wrong = 3 * 0.9**2 + 0.6**2
        right = 3 * 0.1**2 + 0.2**2
        self.assertAlmostEqual(found["brier_score"], (wrong + right) / 8)
        log = 3 * math.log(0.1) + math.log(0.4)
        log += 3 * math.log(0.9) + math.log(0.8)
        self.assertAlmostEqual(found["log_score"], -log / 8)
        self.assertEqual(found["confusion"]["small"]["reflex"], {"none": 1})

    def test_table_and_picture_are_written(self):
        out = self.folder / "score"
        status, printed, _ = self.run_score("--out", out)
        self.assertEqual(status, 0)
        self.assertIn("force_lag large -> hardening", printed)
        self.assertTrue((out / "score.json").exists())
        self.assertIn("<svg", (out / "reliability.svg").read_text())

    def test_no_cases_of_a_kind_are_no_division_by_zero(self):
        found = score(self.judged()[:1], least=0.3)
        self.assertIn("no such case", format_score(found))
        draw_reliability(found)

    def test_labels(self):
        self.assertEqual(label(None), "failed")
        self.assertEqual(label(verdict()), "none")
        self.assertEqual(label(verdict(outside=True)), "outside")
        self.assertEqual(label(verdict(["b", "a"])), "a+b")
        self.assertEqual(label(verdict(["b"], outside=True)), "b+outside")

    def test_a_recording_that_is_blamed_wrongly_is_no_right_answer(self):
        faulty = [{"fault": "wrong_scale", "probability": 0.99}]
        said = verdict(p=0.99) | {"gap": True, "recording": faulty}
        for kind in ("none", "single", "outside"):
            effects = [] if kind == "none" else ["reflex"]
            judged = Judged("a", truth(kind, effects, []), said)
            self.assertEqual(judged.given, "recording")
            self.assertFalse(judged.right)
            self.assertTrue(judged.errs_surely)
            self.assertEqual(judged.answers, [])

    def test_what_is_partly_explained_is_right_for_neither(self):
        told = verdict(["reflex"], ["torso"], outside=True, rivals=["posture"])
        for kind, effects in (("single", ["reflex"]), ("outside", ["tremor"])):
            case = Judged("case", truth(kind, effects, ["torso"]), told)
            self.assertFalse(case.right)
            self.assertFalse(case.covered)
            self.assertEqual(case.named, {"reflex"})
            self.assertEqual(
                case.answers, ["reflex+outside", "posture+outside"]
            )


class TestTampering(WithFiles):
    def refused(self, error, words):
        with self.assertRaisesRegex(error, words):
            self.judged()
        status, _, errors = self.run_score()
        self.assertEqual(status, 2)
        self.assertEqual(len(errors.strip().splitlines()), 1)

    def test_a_changed_truth_is_noticed(self):
        document = json.loads(self.vault.read_text())
        document["cases"]["case002"]["truth"]["effects"] = ["hardening"]
        self.vault.write_text(json.dumps(document))
        self.refused(SealError, "case002")

    def test_a_changed_answer_is_noticed(self):
        path = self.answers / "answers.json"
        path.write_text(path.read_text().replace("hardening", "force_lag"))
        self.refused(SealError, "changed since the commitment")

    def test_a_changed_promise_is_noticed(self):
        with (self.folder / SEALS).open("a") as file:
            file.write("\n")
        self.refused(SealError, "changed since the commitment")

    def test_a_missing_vault_is_one_clear_line(self):
        self.vault.unlink()
        self.refused(AnswerError, "vault.json")


if __name__ == "__main__":
    unittest.main()

"""Answers, truths and names of withheld cases that no case can have."""

import copy
import unittest

from brace_drake.withheld.schemas import ANSWER, SEALED, check_shape
from brace_drake.withheld.seals import AnswerError, read_seals
from tests.test_withheld_score import WithFiles, truth, verdict

BAD_ANSWERS = (
    ("verdict", "gap"),
    ("verdict", []),
    ("verdict.gap", "false"),
    ("verdict.effects", "backlash"),
    ("verdict.effects", [3]),
    ("verdict.effects", ["backlash", "backlash"]),
    ("verdict.blocks", None),
    ("verdict.probability", 7.5),
    ("verdict.probability", True),
    ("verdict.ambiguous_with", None),
    ("closed", "much"),
    ("closed", 1e9),
    ("closed", True),
    ("seconds", -5.0),
)
BAD_TRUTHS = (
    ("truth", "single"),
    ("truth.kind", "triple"),
    ("truth.severity", []),
    ("truth.severity", 3),
    ("truth.effects", None),
    ("truth.blocks", None),
    ("truth.floors", "deep"),
    ("truth.floors", None),
    ("salt", 5),
    ("salt", None),
)


def changed(document, place, value):
    """A copy with another value at a place such as "verdict.gap"."""
    document = copy.deepcopy(document)
    *parents, last = place.split(".")
    inner = document
    for name in parents:
        inner = inner[name]
    inner[last] = value
    return document


class TestShapes(unittest.TestCase):
    def refuse(self, document, schema, cases):
        check_shape("file: case", document, schema)
        for place, value in cases:
            with (
                self.subTest(place=place, value=value),
                self.assertRaises(AnswerError) as raised,
            ):
                check_shape(
                    "file: case", changed(document, place, value), schema
                )
            self.assertIn(f"file: case: {place}", str(raised.exception))

    def test_an_answer_that_none_can_give_is_refused_with_its_place(self):
        answer = {"verdict": verdict(["backlash"]), "closed": 0.9}
        answer["verdict"]["ambiguous_with"] = []
        self.refuse(answer | {"seconds": 5.0}, ANSWER, BAD_ANSWERS)

    def test_a_truth_that_no_case_has_is_refused_with_its_place(self):
        sealed = {"truth": truth("single", ["backlash"], []), "salt": "a"}
        self.refuse(sealed, SEALED, BAD_TRUTHS)

    def test_what_is_outside_has_a_name(self):
        sealed = {"truth": truth("outside", [], []), "salt": "a"}
        sealed["truth"]["outside"] = []
        with self.assertRaisesRegex(AnswerError, "truth.outside"):
            check_shape("vault", sealed, SEALED)


class TestNames(WithFiles):
    def test_a_case_that_would_leave_its_folder_is_refused(self):
        for name in ("../victim", "/tmp/victim", ".", "..", "a/b", "a\\nb", ""):
            (self.folder / "SEALS.yaml").write_text(f'seals: {{"{name}": "0"}}')
            with (
                self.subTest(name=name),
                self.assertRaisesRegex(AnswerError, "allowed: letters"),
            ):
                read_seals(self.folder)


if __name__ == "__main__":
    unittest.main()

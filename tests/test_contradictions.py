"""Nothing is announced that the same document contradicts."""

import json
import math
import unittest
from collections.abc import Iterator

from brace_drake.document.document import FORMAT
from brace_drake.selection import thresholds
from tests import diagnoses
from tests.shared_data import EXAMPLE


def contradictions(document: dict) -> list[str]:
    """What a document of a diagnosis says against itself."""
    return [
        *_of_effects(document),
        *_of_the_rest(document),
        *_of_validation(document),
        *_of_causes(document),
        *_of_words(document),
    ]


def _of_effects(document: dict) -> Iterator[str]:
    verdict = document["verdict"]
    rows, named = verdict["supported"], verdict["effects"]
    if [row["effect"] for row in rows] != named:
        yield "supported are others than those named"
    if not {row["block"] for row in rows} <= set(verdict["blocks"]):
        yield "an effect's block is not among the blocks"
    if named and not verdict["gap"]:
        yield "effects without a gap"
    for row in rows:
        if row["probability"] < verdict["probability"]:
            yield "an effect is less probable than the whole verdict"
        ends = row["closes_interval"]
        if ends is not None and ends[1] < 0.0:
            yield "an effect makes the validation runs worse"


def _of_the_rest(document: dict) -> Iterator[str]:
    """`outside_library` is what is left, where that is material."""
    verdict, made = document["verdict"], document["provenance"]
    share, outside = verdict["unexplained"]["share"], verdict["outside_library"]
    if not verdict["gap"]:
        if outside or share or verdict["blocks"]:
            yield "something is left without a gap"
        return
    is_material = share > made["material_share"]
    chosen = next((c for c in document["causes"] if c["chosen"]), None)
    if chosen is not None:
        is_material &= _is_beyond_level(chosen, made["level"])
    if outside != is_material:
        yield "what is left is not what outside_library says"
    if not (verdict["effects"] or outside):
        yield "a gap of nothing"


def _is_beyond_level(cause: dict, level: float) -> bool:
    inside = max(0.0, cause["excess"])
    held_out = cause["held_out"]
    predicted = inside if held_out is None else max(0.0, held_out)
    left = math.sqrt((inside + level) * (predicted + level))
    return left > thresholds.BEYOND_LEVEL * level


def _of_validation(document: dict) -> Iterator[str]:
    verdict, shrink = document["verdict"], document["shrink"]
    why, confirmed = verdict["contradicted"], verdict["confirmed"]
    if (confirmed is False) != bool(why):
        yield "not confirmed, and nothing that contradicts"
    if confirmed and not _tells_something(document):
        yield "confirmed by validation runs that tell nothing"
    if confirmed is None and _tells_something(document):
        yield "not confirmed by validation runs that tell something"
    if why and any(f"{name} (" in why for name in verdict["effects"]):
        yield "what is contradicted is named all the same"
    if why and verdict["probability"] > 0.5:
        yield "what is contradicted is held for probable"
    if shrink is None:
        return
    repaired = shrink["closed"] is not None
    if verdict["effects"] and repaired:
        if not shrink["after"] < shrink["before"]:
            yield "the effects do not shrink the gap"
    if not verdict["gap"] and shrink["after"] > _most_without_gap(document):
        yield "no gap, yet the validation runs are off"


def _tells_something(document: dict) -> bool:
    """Whether validation runs show the gap and what closes it, or no gap."""
    verdict, shrink = document["verdict"], document["shrink"]
    if shrink is None:
        return False
    if verdict["effects"]:
        return shrink["closed"] is not None
    return not verdict["gap"] or shrink["before"] > _most_without_gap(document)


def _most_without_gap(document: dict) -> float:
    """Times the floor that a right twin is off at most."""
    level = document["provenance"]["level"]
    return math.sqrt(1.0 + thresholds.BEYOND_LEVEL * level)


def _of_causes(document: dict) -> Iterator[str]:
    verdict, causes = document["verdict"], document["causes"]
    chosen = [c for c in causes if c["chosen"]]
    kinds = set().union(*map(_names, chosen))
    if len(chosen) > 1 or not set(verdict["effects"]) <= kinds:
        yield "the cause chosen has not the effects named"
    for cause in causes:
        if not cause["searched"] and (
            cause["explained"] is not None or cause["score"] is not None
        ):
            yield "a cause that was screened only has figures of a search"
        if cause["converged"] and not cause["searched"]:
            yield "a cause is led to its end and was not searched"
    for rival in verdict["ambiguous_with"]:
        if not any(set(rival.split("+")) <= _names(c) for c in causes):
            yield "a rival is no cause"
        if set(rival.split("+")) == set(verdict["effects"]):
            yield "the verdict is its own rival"


def _names(cause: dict) -> set[str]:
    """Names of a cause's effects, without their forms."""
    return {part.partition(" (")[0] for part in cause["effect"].split("+")}


def _of_words(document: dict) -> Iterator[str]:
    verdict, sentence = document["verdict"], document["verdict"]["sentence"]
    if sentence.startswith("No gap") == verdict["gap"]:
        yield "the sentence has a gap where there is none, or none"
    for row in verdict["supported"]:
        if row["title"].lower() not in sentence.lower():
            yield "the sentence leaves out an effect"
    why = verdict["contradicted"]
    if why and (
        why not in sentence or f"withdrawn: {why}" not in _told(document)
    ):
        yield "what contradicts is not told"
    if verdict["effects"] and verdict["outside_library"]:
        if "is left" not in sentence:
            yield "the sentence does not say what is left"
    rows = [p for r in verdict["supported"] for p in r["parameters"]]
    for row in rows:
        told = any(
            w.startswith(f"{row['name']} is at its limit")
            for w in _told(document)
        )
        if told != row["at_limit"]:
            yield "a parameter is at its limit and that is not told, or not"
    for row in document["tolerances"]:
        if abs(row["deviations"]) <= 2.0:
            yield "a number is listed that is within two tolerances"


def _told(document: dict) -> list[str]:
    return document["warnings"]


class StoredTest(unittest.TestCase):
    def test_no_stored_diagnosis_contradicts_itself(self):
        paths = sorted(EXAMPLE.parent.rglob("diagnosis.json"))
        self.assertTrue(paths)
        for path in paths:
            with self.subTest(path=path):
                document = json.loads(path.read_text())
                self.assertEqual(document["format"], FORMAT)
                self.assertEqual(contradictions(document), [])


class ConstructedTest(unittest.TestCase):
    def test_no_kind_of_verdict_contradicts_itself(self):
        for make in diagnoses.ALL:
            with self.subTest(make.__name__):
                self.assertEqual(contradictions(make()), [])

    def found(self, make, **changes):
        """What is found once a part of a document's verdict is another."""
        document = make()
        document["verdict"] |= changes
        return contradictions(document)

    def test_other_rows_than_effects_are_found(self):
        for changes in (
            {"effects": ["backlash"]},
            {"supported": []},
            {"blocks": ["sensing"]},
            {"gap": False},
        ):
            with self.subTest(changes):
                self.assertTrue(self.found(diagnoses.make_diagnosis, **changes))

    def test_a_rest_that_is_none_and_none_that_is_one_are_found(self):
        for make in diagnoses.ALL:
            with self.subTest(make.__name__):
                before = make()["verdict"]["outside_library"]
                self.assertTrue(self.found(make, outside_library=not before))

    def test_a_repair_that_makes_it_worse_is_found(self):
        document = diagnoses.make_diagnosis()
        shrink = document["shrink"]
        shrink["after"] = 1.01 * shrink["before"]
        self.assertTrue(contradictions(document))
        document = diagnoses.make_partly()
        row = document["verdict"]["supported"][0]
        row["closes_interval"] = [-0.2, -0.1]
        self.assertTrue(contradictions(document))

    def test_no_gap_with_validation_runs_that_are_off_is_found(self):
        document = diagnoses.make_without_gap()
        shrink = document["shrink"] = diagnoses.make_diagnosis()["shrink"]
        shrink["after"] = shrink["before"]
        document["verdict"]["confirmed"] = True
        self.assertEqual(
            contradictions(document),
            ["no gap, yet the validation runs are off"],
        )

    def test_what_contradicts_has_to_be_told(self):
        for changes in (
            {"contradicted": None},
            {"confirmed": True},
            {"confirmed": None},
            {"sentence": "There is a gap."},
        ):
            with self.subTest(changes):
                self.assertTrue(self.found(diagnoses.make_withdrawn, **changes))
        document = diagnoses.make_withdrawn()
        document["warnings"] = []
        self.assertTrue(contradictions(document))

    def test_a_repair_that_breaks_down_confirms_nothing(self):
        document = diagnoses.make_diagnosis()
        shrink = document["shrink"]
        shrink |= {"after": shrink["before"], "closed": None}
        self.assertTrue(contradictions(document))
        document["verdict"]["confirmed"] = None
        self.assertEqual(contradictions(document), [])

    def test_an_effect_withdrawn_by_itself_is_not_named(self):
        document = diagnoses.make_partly_withdrawn()
        (name,) = document["verdict"]["effects"]
        for changes in (
            {"contradicted": f"{name} (contact) makes them worse"},
            {"probability": 0.9},
            {"confirmed": None},
        ):
            with self.subTest(changes):
                self.assertTrue(
                    self.found(diagnoses.make_partly_withdrawn, **changes)
                )
        self.assertEqual(contradictions(document), [])

    def test_a_cause_that_was_screened_only_has_no_share(self):
        document = diagnoses.make_diagnosis()
        row = next(c for c in document["causes"] if not c["searched"])
        row["explained"] = 0.1
        self.assertTrue(contradictions(document))

    def test_the_sentence_says_what_is_left(self):
        title = diagnoses.STORED["verdict"]["supported"][0]["title"]
        for words in ("No gap.", "There is a gap.", f"It is {title}."):
            with self.subTest(words):
                self.assertTrue(
                    self.found(diagnoses.make_partly, sentence=words)
                )


if __name__ == "__main__":
    unittest.main()

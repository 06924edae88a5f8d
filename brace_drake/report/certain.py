"""What is certain and what is left, as the page shows it."""

from __future__ import annotations

import math

from brace_drake.effects.registry import find_effect
from brace_drake.report.cards import name_of, parts_of
from brace_drake.report.words import (
    NOTHING,
    decimals_for,
    fixed,
    parameter_row,
    parameter_text,
    percent,
    percent_interval,
    scale_of,
    significant,
    times,
    to_number,
)

NONE, GAP, PARTLY = "none", "gap", "partly"
OUTSIDE, WITHDRAWN, RECORDING = "outside", "withdrawn", "recording"
BADGES = {
    GAP: "Gap",
    NONE: "No gap",
    PARTLY: "Gap, partly explained",
    OUTSIDE: "Outside the library",
    WITHDRAWN: "Withdrawn",
    RECORDING: "Fault of the recording",
}


def kind_of(verdict: dict) -> str:
    """Which of BADGES a verdict of a document is."""
    if verdict.get("contradicted") and not verdict["effects"]:
        return WITHDRAWN
    if not verdict["gap"]:
        return NONE
    if not verdict["effects"]:
        return OUTSIDE if verdict["outside_library"] else RECORDING
    return PARTLY if verdict["outside_library"] else GAP


def describe_certain(diagnosis: dict) -> dict:
    """Effects that are named, what is left, what validation says of both."""
    verdict = diagnosis["verdict"]
    law = verdict["unexplained"]["law"]
    ends = (law or {}).get("closed_interval") or (None, None)
    closed, interval = percent_interval((law or {}).get("closed"), *ends)
    return {
        "supported": [_supported_row(row) for row in verdict["supported"]],
        "rest": _rest_text(verdict),
        "within": [
            _within_text(part, cause)
            for cause in diagnosis["causes"]
            if cause["chosen"] and verdict["gap"]
            for part in parts_of(cause["effect"])
            if name_of(part) not in verdict["effects"]
        ],
        "law": _law_rows(law),
        "law_closed": "" if closed == NOTHING else closed,
        "law_interval": interval,
        "validation": _validation_text(verdict, diagnosis["shrink"]),
        "faults": verdict["recording"],
        "moved": [_moved_row(row) for row in diagnosis["tolerances"]],
    }


def _supported_row(row: dict) -> dict:
    ends = row["closes_interval"] or (None, None)
    share, interval = percent_interval(row["closes"], *ends)
    return row | {
        "share": share,
        "interval": interval,
        "parameters": [parameter_row(p) for p in row["parameters"]],
    }


def _within_text(part: str, cause: dict) -> str:
    """An effect of the repaired twin that is no finding."""
    effect = find_effect(part)
    own = [
        p for p in cause["parameters"] if p["name"] in effect.parameter_names
    ]
    rows = map(parameter_row, own)
    values = ", ".join(f"{r['name']} {r['value']} {r['unit']}" for r in rows)
    return (
        f"The repaired twin also has {effect.title} ({values}). That is within"
        " the tolerance that the scenario allows, so it is no finding."
    )


def _law_rows(law: dict | None) -> list[dict]:
    """A row for each term of a law."""
    terms = law["terms"] if law else []
    return [
        {
            "text": term["text"],
            "formula": term["formula"],
            "usual": term["usual"],
            "numbers": ", ".join(map(_number_text, term["parameters"])),
        }
        for term in terms
    ]


def _number_text(row: dict) -> str:
    value, error = row["value"], row["standard_error"]
    text = f"{row['name']} = {significant(value, 4)}"
    if error is not None:
        text += f" ± {significant(1.96 * error, 2)}"
    return f"{text} {row['unit']}".removesuffix(" 1")


def _rest_text(verdict: dict) -> str:
    """What is left of the gap, as a sentence; empty where there is no gap."""
    left = verdict["unexplained"]
    if not verdict["gap"]:
        return ""
    if not left["share"]:
        return "Nothing is left beyond what a right twin leaves."
    text = f"{percent(left['share'])} of the gap is left"
    if left["block"]:
        text += f", in {left['block']}"
    if left["description"]:
        text += f"; it {left['description']}"
    if left["law"]:
        text += f". It acts like {left['law']['text']}"
    if verdict["outside_library"]:
        return f"{text}. No effect of the library explains that."
    return f"{text}. That is too little to be called a further cause."


def _validation_text(verdict: dict, shrink: dict | None) -> str:
    """What runs that no fit has seen say of the verdict."""
    if shrink is None:
        return (
            "There is no validation run that could confirm or contradict this."
        )
    before, after = times(shrink["before"]), times(shrink["after"])
    if verdict["confirmed"] is None:
        if shrink["before"] <= 1.0 or not verdict["effects"]:
            return (
                "The validation runs do not show the gap: they neither confirm"
                " nor contradict this."
            )
        return (
            "The repaired twin breaks down on the validation runs: they neither"
            " confirm nor contradict this."
        )
    if not verdict["confirmed"]:
        why = verdict["contradicted"]
        text = f"The validation runs contradict what the fit runs said: {why}."
        if not verdict["effects"]:
            return f"{text} It is withdrawn."
        return (
            f"{text} That is withdrawn; with what is named the gap goes from"
            f" {before} to {after} times the floor."
        )
    if not verdict["gap"]:
        return (
            f"The validation runs confirm it: on them the twin is {after}"
            " times the floor off."
        )
    if not verdict["effects"]:
        return (
            f"The validation runs confirm that there is a gap: {before} times"
            " the floor."
        )
    return (
        "The validation runs confirm it: with the effects the gap goes from"
        f" {before} to {after} times the floor."
    )


def _moved_row(row: dict) -> dict:
    """A number known to a tolerance that the data put elsewhere."""
    keys = ("value", "tolerance", "standard_error")
    found = [to_number(row[key]) for key in keys]
    factor, unit = scale_of(row["unit"], found[:1])
    value, tolerance, error = (v * factor for v in found)
    decimals = decimals_for(error, value if math.isfinite(value) else 0.0)
    return {
        "name": parameter_text(row["name"], row["unit"]),
        "column": row["name"],
        "block": row["block"],
        "unit": unit,
        "tolerance": significant(tolerance, 3),
        "value": fixed(value, decimals),
        "error": significant(error, 2, padded=True),
        "deviations": fixed(row["deviations"], 1),
    }

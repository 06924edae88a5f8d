"""What the templates show beside the document: figures, sentences, rows."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.effects.registry import find_effect
from brace_drake.report.canvas import WIDTH
from brace_drake.report.cards import make_cards, parts_of
from brace_drake.report.certain import BADGES, describe_certain, kind_of
from brace_drake.report.figures.bars import (
    draw_blocks,
    draw_correlation,
    draw_pairs,
)
from brace_drake.report.figures.budget import draw_attribution, draw_power
from brace_drake.report.law_curve import LawCurve, view_law
from brace_drake.report.origin import view_origin
from brace_drake.report.rivals import view_causes
from brace_drake.report.runs import view_runs
from brace_drake.report.traces import RunTrace
from brace_drake.report.words import (
    NOTHING,
    TIMES_FLOOR,
    band_text,
    channel_text,
    error_row,
    parameter_row,
    percent_interval,
    times,
)


def make_view(
    diagnosis: dict,
    traces: Sequence[RunTrace],
    laws: Sequence[LawCurve] = (),
) -> dict:
    """The document, and beside its parts what the templates need of them."""
    verdict, causes = diagnosis["verdict"], diagnosis["causes"]
    kind = kind_of(verdict)
    return diagnosis | {
        "kind": kind,
        "badge": BADGES[kind],
        "certain": describe_certain(diagnosis),
        "lead": _lead(diagnosis["where"]["blocks"]),
        "blocks": diagnosis["where"]["blocks"],
        "figures": _draw_where(diagnosis["where"]),
        "cards": make_cards(causes, verdict),
        "how_far": _how_far(diagnosis["shrink"]),
        "fitted": _fitted(causes),
        "runs": view_runs(traces, diagnosis["runs"]),
        "laws": [view_law(law) for law in laws],
        "origin": view_origin(diagnosis),
        **view_causes(causes, verdict),
        **_subject(diagnosis["subject"]),
    }


def _lead(blocks: list[dict]) -> str:
    guilty = [b for b in blocks if not b["acquitted"]]
    if not blocks:
        return ""
    if not guilty:
        return "Every block, replayed on its own, stays within its threshold."
    guilty.sort(key=lambda b: -b["normalised_rms"])
    parts = [
        f"{b['block']} ({times(b['normalised_rms'])} times its floor)"
        for b in guilty
    ]
    lead = f"Not explained by noise: {', '.join(parts)}."
    acquitted = len(blocks) - len(guilty)
    if acquitted:
        lead += f" {acquitted} of {len(blocks)} blocks within their threshold."
    return lead


def _draw_where(where: dict) -> dict:
    channels, phases = where["channels"], where["phases"]
    names = [channel_text(row["channel"]) for row in channels]
    bands = [band_text(row) for row in where["bands"]]
    return {
        "attribution": draw_attribution(where["attribution"]),
        "power": draw_power(where["cube"]),
        "blocks": draw_blocks(where["blocks"]),
        "channels": draw_pairs(names, channels, WIDTH),
        "phases": draw_pairs([r["phase"] for r in phases], phases, WIDTH / 2.0),
        "bands": draw_pairs(bands, where["bands"], WIDTH / 2.0),
    }


def _how_far(shrink: dict | None) -> dict | None:
    """Errors on the validation runs; None where there are none."""
    if shrink is None:
        return None
    # With nothing added, after is before.
    repaired = shrink["after"] != shrink["before"]
    ends = shrink["closed_interval"] or (None, None)
    closed, interval = percent_interval(shrink["closed"], *ends)
    channels = [
        # What is told over the floor has no unit.
        error_row(channel_text(row["channel"]), TIMES_FLOOR, row)
        | {"column": row["channel"]}
        for row in shrink["channels"]
    ]
    told = [
        error_row(row["title"], row["unit"], row)
        for row in shrink.values()
        if isinstance(row, dict) and "title" in row
    ]
    if not repaired:
        for row in (*channels, *told):
            row |= {"after": NOTHING, "interval": ""}
    return {
        "repaired": repaired,
        "before": times(shrink["before"]),
        "after": times(shrink["after"]) if repaired else NOTHING,
        "floor": times(shrink["floor"]),
        "closed": closed,
        "interval": interval,
        "channels": channels,
        "quantities": told,
    }


def _fitted(causes: list[dict]) -> str:
    """What was estimated on the validation runs themselves."""
    chosen = [p for c in causes if c["chosen"] for p in parts_of(c["effect"])]
    if any(find_effect(name).run_parameters for name in chosen):
        return "only what each run has of its own"
    return "nothing"


def _subject(subject: dict) -> dict:
    parameters = [parameter_row(p) for p in subject["parameters"]]
    names = [p["name"] for p in parameters]
    return {
        "subject_rows": parameters,
        "correlation": draw_correlation(names, subject["correlation"]),
    }

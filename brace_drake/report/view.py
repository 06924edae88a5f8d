"""What the templates show beside the document: figures, sentences, rows."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.effects.registry import find_effect
from brace_drake.report.budget_figures import draw_attribution, draw_cube
from brace_drake.report.canvas import WIDTH
from brace_drake.report.cards import make_cards, name_of, parts_of
from brace_drake.report.certain import BADGES, describe_certain, kind_of
from brace_drake.report.figures import draw_blocks, draw_correlation, draw_pairs
from brace_drake.report.trace_figures import draw_plane, draw_trace
from brace_drake.report.traces import VALIDATION, RunTrace
from brace_drake.report.words import (
    NOTHING,
    band_text,
    channel_text,
    error_row,
    over_floor,
    parameter_row,
    percent_interval,
    times,
    to_number,
    to_text,
)

# More runs than these would not be read, and the file would grow.
_MOST_TRACES = 4
_MOST_PLANES = 1
# Keys of the provenance that are mean squares above the floor's.
_MISFITS = ("misfit", "level")


def make_view(diagnosis: dict, traces: Sequence[RunTrace]) -> dict:
    """The document, and beside its parts what the templates need of them."""
    verdict, causes = diagnosis["verdict"], diagnosis["causes"]
    searched = [
        cause | {"parameters": [parameter_row(p) for p in cause["parameters"]]}
        for cause in causes
        if cause["searched"]
    ]
    kind = kind_of(verdict)
    return diagnosis | {
        "kind": kind,
        "badge": BADGES[kind],
        "certain": describe_certain(diagnosis),
        "lead": _lead(diagnosis["where"]["blocks"]),
        "blocks": checked_blocks(diagnosis["where"]),
        "figures": _draw_where(diagnosis["where"]),
        "searched": searched,
        "screened": [c["effect"] for c in causes if not c["searched"]],
        "cards": make_cards(causes, verdict),
        "how_far": _how_far(diagnosis["shrink"]),
        "fitted": _fitted(causes),
        "runs": _draw_runs(traces),
        "made_from": _made_from(diagnosis["provenance"]),
        **_subject(diagnosis["subject"]),
        **_open_causes(causes, verdict),
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
        "cube": draw_cube(where["cube"]),
        "blocks": draw_blocks(checked_blocks(where)),
        "channels": draw_pairs(names, channels, WIDTH),
        "phases": draw_pairs([r["phase"] for r in phases], phases, WIDTH / 2.0),
        "bands": draw_pairs(bands, where["bands"], WIDTH / 2.0),
    }


def checked_blocks(where: dict) -> list[dict]:
    """The tests of single blocks, and that of the contact side after them."""
    side = where["contact_side"]
    return [*where["blocks"], *([side] if side else [])]


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
        error_row(channel_text(row["channel"]), "× floor", row)
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


def _draw_runs(traces: Sequence[RunTrace]) -> dict:
    validation = [t for t in traces if t.split == VALIDATION]
    picked = (validation or list(traces))[:_MOST_TRACES]
    figures = [
        {
            "run": trace.name,
            "split": trace.split,
            "image": draw_trace(trace),
            "plane": draw_plane(trace) if i < _MOST_PLANES else None,
        }
        for i, trace in enumerate(picked)
    ]
    return {
        "figures": [f for f in figures if f["image"]],
        "validated": bool(validation),
        "left_out": max(0, len(validation) - _MOST_TRACES),
    }


def _subject(subject: dict) -> dict:
    parameters = [parameter_row(p) for p in subject["parameters"]]
    names = [p["name"] for p in parameters]
    return {
        "subject_rows": parameters,
        "correlation": draw_correlation(names, subject["correlation"]),
    }


def _open_causes(causes: list[dict], verdict: dict) -> dict:
    """Causes whose search was not led to its end: those that explain as much
    of the gap as the best that was, and the others.
    """
    if not verdict["gap"]:
        return {"unconverged": [], "left_early": []}
    chosen, led = set(verdict["effects"]), [c for c in causes if c["converged"]]
    first = [c for c in led if c["chosen"]] or led
    most = max((to_number(c["explained"]) for c in first), default=0.0)
    # What the verdict holds already is part of a fit that has converged.
    unconverged = [
        c
        for c in causes
        if c["searched"]
        and not c["converged"]
        and not {name_of(p) for p in parts_of(c["effect"])} <= chosen
    ]
    far = [c for c in unconverged if to_number(c["explained"]) < most]
    return {
        "unconverged": [c["effect"] for c in unconverged if c not in far],
        "left_early": [c["effect"] for c in far],
    }


def _made_from(provenance: dict) -> list[tuple[str, str]]:
    """Rows of the provenance; misfits as multiples of the floor."""
    rows = []
    for name, value in provenance.items():
        if isinstance(value, dict):
            rows += [(f"{name}.{k}", to_text(v)) for k, v in value.items()]
        elif name in _MISFITS:
            rows.append((name, f"{over_floor(value)} × floor"))
        else:
            rows.append((name, to_text(value)))
    return rows

"""What the template shows: tables, figures and sentences of a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Sequence

from brace_drake.report.access import (
    bar_width,
    items,
    names,
    numbers,
    part,
    rows,
    text,
)
from brace_drake.report.budget_figures import draw_attribution, draw_cube
from brace_drake.report.canvas import WIDTH
from brace_drake.report.cards import has_run_parameters, make_cards
from brace_drake.report.figures import draw_blocks, draw_correlation, draw_pairs
from brace_drake.report.plane_figures import draw_plane
from brace_drake.report.tables import (
    attribution_row,
    balance_row,
    band_text,
    block_row,
    cause_row,
    channel_row,
    gap_row,
    is_searched,
    left_row,
    name_of,
    parameter_row,
    parts_of,
    receipt_rows,
    shrink_rows,
    therapist_rows,
)
from brace_drake.report.trace_figures import draw_trace
from brace_drake.report.traces import VALIDATION, RunTrace, pick_traces
from brace_drake.report.words import (
    NOTHING,
    channel_text,
    percent,
    percent_interval,
    significant,
    times,
    to_number,
)

# More runs than these would not be read, and the file would grow.
_MOST_TRACES = 4
_MOST_PLANES = 1
# Least share of the gap that any verdict asks of an effect that explains it.
_NEAR = 0.75


def make_view(diagnosis: dict, traces: Sequence[RunTrace]) -> dict:
    """Everything the template needs, in its words."""
    verdict = part(diagnosis, "verdict")
    return {
        "head": _make_head(diagnosis, verdict),
        "where": _make_where(part(diagnosis, "where")),
        "which": _make_which(diagnosis, verdict),
        "how_far": _make_how_far(diagnosis, verdict, traces),
        "subject": _make_subject(part(diagnosis, "subject")),
        "notes": _make_notes(diagnosis, verdict),
        "receipt": receipt_rows(part(diagnosis, "receipt")),
        "nothing": NOTHING,
    }


def _make_head(diagnosis: dict, verdict: dict) -> dict:
    if verdict.get("outside_library"):
        kind, badge = "outside", "Outside the library"
    elif verdict.get("gap"):
        kind, badge = "gap", "Gap"
    elif verdict.get("gap") is False:
        kind, badge = "none", "No gap"
    else:
        kind, badge = "unknown", "No verdict"
    return {
        "campaign": text(diagnosis, "campaign") or "unnamed campaign",
        "device": text(diagnosis, "device") or NOTHING,
        "subject": text(diagnosis, "subject_name") or NOTHING,
        "version": text(part(diagnosis, "receipt", "versions"), "brace_drake")
        or NOTHING,
        "kind": kind,
        "badge": badge,
        "sentence": text(verdict, "sentence") or "No verdict was reached.",
        "probability": percent(verdict.get("probability")),
        "width": bar_width(verdict.get("probability")),
        "effects": names(verdict, "effects"),
        "blocks": names(verdict, "blocks"),
        "ambiguous": names(verdict, "ambiguous_with"),
    }


def _make_where(where: dict) -> dict:
    blocks = rows(where, "blocks")
    side = part(where, "contact_side")
    checked = [*blocks, side] if side else blocks
    channels = rows(where, "channels")
    phases, bands = rows(where, "phases"), rows(where, "bands")
    shares = rows(where, "attribution")
    labels = [channel_text(text(row, "channel")) for row in channels]
    phase_labels = [text(row, "phase") or NOTHING for row in phases]
    band_labels = [band_text(row) for row in bands]
    return {
        "lead": _where_lead(blocks),
        "attribution": [attribution_row(r) for r in shares],
        "attribution_by": text(where, "attribution_by"),
        "attribution_figure": draw_attribution(shares),
        "cube_figure": draw_cube(rows(where, "cube")),
        "blocks": [block_row(b) for b in checked],
        "block_figure": draw_blocks(checked),
        "balance": [balance_row(r) for r in rows(where, "balance")],
        "channels": [channel_row(row) for row in channels],
        "channel_figure": _draw(labels, channels, WIDTH),
        "phases": [gap_row(*p) for p in zip(phase_labels, phases, strict=True)],
        "phase_figure": _draw(phase_labels, phases, WIDTH / 2.0),
        "bands": [gap_row(*b) for b in zip(band_labels, bands, strict=True)],
        "band_figure": _draw(band_labels, bands, WIDTH / 2.0),
    }


def _draw(labels: list[str], found: list[dict], width: float) -> str | None:
    before, after = numbers(found, "before"), numbers(found, "after")
    return draw_pairs(labels, before, after, width)


def _where_lead(blocks: list[dict]) -> str:
    guilty = [b for b in blocks if not b.get("acquitted")]
    if not blocks:
        return ""
    if not guilty:
        return "Every block, replayed on its own, stays at its noise floor."
    guilty.sort(key=lambda b: -_or_zero(b.get("normalised_rms")))
    parts = [
        f"{text(b, 'block')} ({times(b.get('normalised_rms'))} times its floor)"
        for b in guilty
    ]
    acquitted = len(blocks) - len(guilty)
    lead = f"Not explained by noise: {', '.join(parts)}."
    if acquitted:
        lead += f" {acquitted} of {len(blocks)} blocks within their threshold."
    return lead


def _or_zero(value: object) -> float:
    number = to_number(value)
    return number if math.isfinite(number) else 0.0


def _make_which(diagnosis: dict, verdict: dict) -> dict:
    causes = rows(diagnosis, "causes")
    return {
        "gap": verdict.get("gap"),
        "outside": bool(verdict.get("outside_library")),
        "causes": [cause_row(c, verdict) for c in causes if is_searched(c)],
        "decoys": next(
            (c["decoys"]["number"] for c in causes if part(c, "decoys")), None
        ),
        "unsearched": [text(c, "effect") for c in causes if not is_searched(c)],
        "cards": make_cards(diagnosis, verdict),
    }


def _make_how_far(
    diagnosis: dict, verdict: dict, traces: Sequence[RunTrace]
) -> dict:
    shrink = part(diagnosis, "shrink")
    picked = pick_traces(list(traces), _MOST_TRACES)
    figures = [
        {
            "run": t.name,
            "split": t.split,
            "image": draw_trace(t),
            "plane": draw_plane(t) if i < _MOST_PLANES else None,
        }
        for i, t in enumerate(picked)
    ]
    validation = [t for t in traces if t.split == VALIDATION]
    closed, interval = _closed(shrink)
    # With nothing added, after is before.
    repaired = shrink.get("after") != shrink.get("before")
    channels, therapist = shrink_rows(shrink), therapist_rows(shrink)
    if not repaired:
        for row in (*channels, *therapist):
            row |= {"after": NOTHING, "interval": ""}
    return {
        "known": bool(shrink),
        "repaired": repaired,
        "fitted": "only what each run has of its own"
        if has_run_parameters(verdict)
        else "nothing",
        "gap": verdict.get("gap"),
        "runs": names(shrink, "runs"),
        "before": times(shrink.get("before")),
        "after": times(shrink.get("after")),
        "floor": times(shrink.get("floor", 1.0)),
        "closed": closed,
        "interval": interval,
        "channels": channels,
        "left": [left_row(r) for r in rows(diagnosis, "left")],
        "therapist": therapist,
        "figures": [f for f in figures if f["image"]],
        "validated": bool(validation),
        "left_out": max(0, len(validation) - _MOST_TRACES),
    }


def _closed(shrink: dict) -> tuple[str, str]:
    interval = [to_number(v) for v in items(shrink, "closed_interval")]
    if len(interval) != 2 or not all(map(math.isfinite, interval)):
        return percent(shrink.get("closed")), ""
    return percent_interval(shrink.get("closed"), *interval)


def _make_subject(subject: dict) -> dict:
    parameters = [parameter_row(p) for p in rows(subject, "parameters")]
    correlation = [
        row if isinstance(row, list) else []
        for row in items(subject, "correlation")
    ]
    return {
        "parameters": parameters,
        "condition": significant(subject.get("condition_number"), 3),
        "correlation": draw_correlation(
            [p["name"] for p in parameters], correlation
        ),
    }


def _make_notes(diagnosis: dict, verdict: dict) -> dict:
    causes = rows(diagnosis, "causes")
    chosen = set(names(verdict, "effects"))
    # What the verdict holds already is part of a fit that has converged.
    unconverged = [
        c
        for c in causes
        if c.get("converged") is False
        and is_searched(c)
        and not {name_of(p) for p in parts_of(text(c, "effect"))} <= chosen
    ]
    far = [c for c in unconverged if to_number(c.get("explained")) < _NEAR]
    near = [c for c in unconverged if c not in far]
    experiment = part(diagnosis, "next_experiment")
    return {
        "warnings": names(diagnosis, "warnings"),
        "ambiguous": names(verdict, "ambiguous_with"),
        "unidentifiable": [
            text(c, "effect") for c in causes if c.get("identifiable") is False
        ],
        "unconverged": [text(c, "effect") for c in near],
        "left_early": [text(c, "effect") for c in far],
        "why": text(experiment, "why"),
        "motion": text(experiment, "motion"),
        "file": text(experiment, "file"),
        "apart": [
            {
                "effects": names(pair, "effects"),
                "deviations": significant(_root(pair.get("separation")), 2),
            }
            for pair in rows(experiment, "pairs")
        ],
    }


def _root(square: object) -> float:
    return math.sqrt(max(0.0, _or_zero(square)))

"""Writes trend.json, trend.csv, and a page that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from brace_drake.core.output import WriteFiles, format_json
from brace_drake.report.page import render_template
from brace_drake.report.words import (
    NOTHING,
    percent,
    scale_of,
    significant,
)
from brace_drake.trend.figures import draw_closed, draw_series
from brace_drake.trend.sentences import number_name
from brace_drake.trend.table import format_csv, number_cells, verdict_word


def trend_files(document: dict, has_page: bool = True) -> dict[str, str]:
    """A trend's files by name, as text, made before any is written.

    Args:
        document: Of `MakeTrendDocument`.
        has_page: Whether there is a trend.html.
    """
    found = {
        "trend.json": format_json(document),
        "trend.csv": format_csv(document),
    }
    return found | ({"trend.html": render_trend(document)} if has_page else {})


def WriteTrend(folder: Path, files: Mapping[str, str]) -> None:
    """Writes what `trend_files` made into a folder that is there.

    Raises:
        OutputError: The place cannot be written.
    """
    WriteFiles({folder / name: text for name, text in files.items()})


def render_trend(document: dict) -> str:
    """The page as HTML text."""
    sessions, rows = document["sessions"], document["parameters"]
    shown = [row for row in rows if row["points"]]
    figures = [
        (number_name(row), draw_series(row, sessions), row["sentence"])
        for row in (document["gap"], *shown)
        if row["points"]
    ]
    closed = draw_closed(sessions)
    if closed:
        text = "What the named effects take of the gap above the floor."
        figures.insert(1, ("share closed", closed, text))
    return render_template(
        "trend.html.j2",
        Path(__file__).parent,
        **document
        | {
            "figures": figures,
            "strip": [_strip_row(row, document) for row in document["effects"]],
            "session_cells": [_session_cells(s) for s in sessions],
            "numbers": [_number_row(r) for r in (*rows, document["gap"])],
        },
    )


def _session_cells(session: dict) -> dict:
    tone = "none" if not session["gap"] else "gap"
    if session["outside_library"]:
        tone = "outside"
    if session["recording_fault"]:
        tone = "failed"
    date = (session["date"] or "").replace("T00:00:00", "").replace("T", " ")
    return session | {
        "day": date,
        "verdict": verdict_word(session),
        "tone": tone,
    }


def _strip_row(row: dict, document: dict) -> dict:
    """Cells of one effect: how probable where it is named."""
    cells = []
    for i, named in enumerate(row["named"]):
        kind = "open" if named is None else "there" if named else "absent"
        told = percent(row["probability"][i]) if named else ""
        word = {"open": "open", "there": told, "absent": "no"}[kind]
        cells.append(
            {
                "kind": kind,
                "text": word,
                "is_alarm": row["alarm"] and i == row["at"],
            }
        )
    return row | {"cells": cells}


def _number_row(row: dict) -> dict:
    name = number_name(row)
    if row["tests"] is None:
        return {"name": name, "note": row["note"], "alarm": None}
    scatter, trend = row["tests"]["scatter"], row["tests"]["trend"] or {}
    far = trend.get("detectable_change")
    return number_cells(row) | {
        "name": name,
        "note": "",
        "alarm": row["alarm"],
        "birge": row["tests"]["constancy"]["birge_ratio"],
        "scatter_text": _range_text(row["unit"], scatter),
        "detectable_text": NOTHING if far is None else _size(row["unit"], far),
    }


def _size(unit: str, value: float) -> str:
    factor, shown = scale_of(unit, [value])
    return f"{significant(value * factor, 2)} {shown}".rstrip()


def _range_text(unit: str, scatter: dict) -> str:
    """A scatter with its interval, which may have no upper end."""
    ends = [scatter[k] for k in ("value", "lower95", "upper95")]
    factor, shown = scale_of(unit, [v for v in ends if v is not None])
    value, low, high = (
        "∞" if v is None else significant(v * factor, 2) for v in ends
    )
    return f"{value} ({low} to {high}) {shown}".rstrip()

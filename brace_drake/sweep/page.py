"""Writes a sweep: sweep.json, sweep.csv, sweep.png and sweep.html."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from brace_drake.core.csv_text import csv_text
from brace_drake.core.output import WriteFiles, format_json
from brace_drake.recording.columns import split_unit
from brace_drake.report.canvas import (
    AFTER,
    FLOOR,
    WIDTH,
    figure_style,
    make_figure,
    plain,
    to_data_uri,
)
from brace_drake.report.page import render_template
from brace_drake.report.words import NOTHING, scale_of, significant

_DPI = 150
_SMALL, _HEIGHT = 4.6, 2.35


def WriteSweep(folder: Path, document: dict) -> None:
    """Writes a sweep's files into a folder.

    Raises:
        OutputError: The place cannot be written.
    """
    WriteFiles(
        {
            folder / "sweep.json": format_json(document),
            folder / "sweep.csv": format_csv(document),
            folder / "sweep.png": draw_png(document),
            folder / "sweep.html": render_sweep(document),
        }
    )


def format_csv(document: dict) -> str:
    """One row for each value: mean of each outcome, and over seeds its
    standard deviation and the 95 % interval of the mean.
    """
    names = [o["name"] for o in document["outcomes"]]
    parts = [("mean", "")]
    if len(document["seeds"]) > 1:
        parts += [("standard_deviation", "_sd")]
        parts += [("lower95", "_lower95"), ("upper95", "_upper95")]
    heads = [_head(name, end) for name in names for _, end in parts]
    rows = []
    for row in document["rows"]:
        cells = [
            row["outcomes"].get(name, {}).get(key, "")
            for name in names
            for key, _ in parts
        ]
        rows.append([row["value"], *cells, row["error"]])
    return csv_text([document["number"]["path"], *heads, "error"], rows)


def _head(name: str, end: str) -> str:
    """A column's name, the unit at its end."""
    quantity, unit = split_unit(name)
    return f"{quantity}{end}_{unit}" if unit else f"{name}{end}"


def outcome_text(name: str) -> str:
    """An outcome as printed: peak_force_N becomes "peak force"."""
    return split_unit(name)[0].replace("_", " ")


def format_text(document: dict) -> str:
    """The sweep as a table for people at a terminal, in units that suit."""
    number, rows = document["number"], document["rows"]
    heads, columns = _columns(document)
    head = f"{number['path']}, {number['unit']}".removesuffix(", ")
    values = [significant(row["value"], 5) for row in rows]
    columns = [[head, *values], *_under(heads, columns)]
    widths = [max(map(len, column)) for column in columns]
    lines = []
    for i, error in enumerate([None, *(row["error"] for row in rows)]):
        cells = [c[i].rjust(w) for c, w in zip(columns, widths, strict=True)]
        if error:
            cells = [cells[0], f"failed: {error}"]
        lines.append("  ".join(cells))
    seeds = len(document["seeds"])
    told = "exact readings" if not seeds else f"mean of {seeds} seeds"
    if seeds > 1:
        told += " ± half of its 95 % interval"
    title = f"{document['scenario']}, {document['motion']}: {told}"
    return "\n".join([title, *lines])


def _under(heads: list[str], columns: list[list[str]]):
    for head, cells in zip(heads, columns, strict=True):
        yield [head, *cells]


def _columns(document: dict) -> tuple[list[str], list[list[str]]]:
    """Head and cells of each outcome."""
    heads, columns = [], []
    for outcome in document["outcomes"]:
        name = outcome["name"]
        own = [row["outcomes"].get(name) for row in document["rows"]]
        factor, unit = scale_of(outcome["unit"], [o["mean"] for o in own if o])
        heads.append(f"{outcome_text(name)}, {unit}")
        columns.append([_cell(o, factor) for o in own])
    return heads, columns


def _cell(outcome: dict | None, factor: float) -> str:
    if outcome is None:
        return NOTHING
    text = significant(outcome["mean"] * factor, 4, padded=True)
    if outcome["upper95"] is None:
        return text
    half = 0.5 * (outcome["upper95"] - outcome["lower95"]) * factor
    return f"{text} ± {significant(half, 2)}"


def draw_png(document: dict) -> bytes:
    """All outcomes in one picture."""
    outcomes = document["outcomes"]
    lines = (len(outcomes) + 1) // 2
    with figure_style():
        figure = make_figure(WIDTH, _HEIGHT * lines)
        panels = figure.subplots(lines, 2, squeeze=False).ravel()
        for axes, outcome in zip(panels, outcomes, strict=False):
            _draw_outcome(axes, document, outcome)
        for axes in panels[len(outcomes) :]:
            axes.set_axis_off()
        buffer = io.BytesIO()
        figure.savefig(
            buffer, format="png", dpi=_DPI, metadata={"Software": None}
        )
    return buffer.getvalue()


def draw_outcome(document: dict, outcome: dict) -> str:
    """One outcome over the number, as a data URI."""
    with figure_style():
        figure = make_figure(_SMALL, _HEIGHT)
        _draw_outcome(figure.subplots(), document, outcome)
        return to_data_uri(figure)


def _draw_outcome(axes, document: dict, outcome: dict) -> None:
    number, name = document["number"], outcome["name"]
    shown = [row for row in document["rows"] if not row["error"]]
    values = [row["value"] for row in shown]
    own = [row["outcomes"][name] for row in shown]
    across, unit_across = scale_of(number["unit"], values)
    factor, unit = scale_of(outcome["unit"], [o["mean"] for o in own])
    x = across * np.array(values)
    y = factor * np.array([o["mean"] for o in own])
    axes.plot(x, y, "o-", ms=4, lw=1.2, color=AFTER, zorder=3)
    if len(document["seeds"]) > 1:
        low, high = (
            factor * np.array([o[key] for o in own])
            for key in ("lower95", "upper95")
        )
        axes.fill_between(x, low, high, color=AFTER, alpha=0.2, lw=0)
    steps = np.diff([row["value"] for row in document["rows"]])
    if not np.allclose(steps, steps[0], rtol=1e-6, atol=0.0):
        axes.set_xscale("log")
        _mark_log(axes, x)
    nominal = number["nominal"] * across
    if min(x) <= nominal <= max(x):
        axes.axvline(nominal, color=FLOOR, lw=0.9, ls=(0, (4, 2)))
    title = f"{outcome_text(name)}, {unit}".removesuffix(", ")
    axes.set_title(plain(f"{title[:1].upper()}{title[1:]}"))
    label = f"{number['path']}, {unit_across}".removesuffix(", ")
    axes.set_xlabel(plain(label))
    axes.grid(axis="y")


def _mark_log(axes, x: np.ndarray) -> None:
    """Plain numbers at the swept values, no more than five."""
    chosen = x[:: max(1, -(-len(x) // 5))]
    axes.set_xticks(chosen, [significant(v, 3) for v in chosen])
    axes.set_xticks([], minor=True)


def render_sweep(document: dict) -> str:
    """The page as HTML text."""
    heads, columns = _columns(document)
    return render_template(
        "sweep.html.j2",
        Path(__file__).parent,
        **document
        | {
            "heads": heads,
            "table": [
                {
                    "value": significant(row["value"], 5),
                    "cells": [column[i] for column in columns],
                    "error": row["error"],
                }
                for i, row in enumerate(document["rows"])
            ],
            "figures": [
                (outcome_text(o["name"]), draw_outcome(document, o))
                for o in document["outcomes"]
            ],
            "nominal": significant(document["number"]["nominal"], 5),
        },
    )

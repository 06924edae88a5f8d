"""An evaluation as one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import math
from pathlib import Path

from brace_drake.core.output import WriteText
from brace_drake.experiments.evaluate import Evaluation
from brace_drake.experiments.evaluation_table import (
    COLUMNS,
    summarize,
    table_1,
)
from brace_drake.experiments.evaluation_words import explain
from brace_drake.experiments.tables import Spread
from brace_drake.report.page import render_template

_TEMPLATE = "evaluation.html.j2"
_CAPTIONS = {
    "figure_8": "Figure 8: position along y",
    "figure_9": "Figure 9: velocity along y",
    "figure_10": "Figure 10: position along x",
    "figure_11": "Figure 11: position along z",
    "figure_12": "Figure 12: force along y",
    "figure_13": "Figure 13: desired stiffness",
}


def WritePage(
    folder: Path, evaluation: Evaluation, figures: dict[str, bytes]
) -> None:
    """Writes evaluation.html.

    Args:
        folder: It exists.
        evaluation: What is told.
        figures: PNG by name, from `WriteFigures`.
    """
    text = render_page(evaluation, figures)
    WriteText(folder / "evaluation.html", text)


def render_page(evaluation: Evaluation, figures: dict[str, bytes]) -> str:
    """The page as HTML text."""
    return render_template(
        _TEMPLATE,
        Path(__file__).parent,
        subjects=len(evaluation.subjects),
        policies=evaluation.policy_names,
        seeds=len(evaluation.policies),
        sentences=explain(evaluation),
        columns=[c.title for c in COLUMNS],
        nominal=[
            {
                "name": row["controller"],
                "seed": row.get("seed", ""),
                "cells": [_cell(row.get(c.name)) for c in COLUMNS],
            }
            for row in table_1(evaluation)
        ],
        unseen=[_shown(row) for row in summarize(evaluation)],
        figures=[(_CAPTIONS[name], _uri(figures[name])) for name in _CAPTIONS],
        picture=_uri(figures["unseen"]),
    )


def _shown(row: dict) -> dict:
    """The cells of an unseen row, intervals below their values."""
    spreads = {k: v for k, v in row.items() if isinstance(v, Spread)}
    return {
        **row,
        **{key: _interval(spread) for key, spread in spreads.items()},
        "violating": _interval(row["violating"], 100.0),
        "better_than_pic": f"{100 * row['better_than_pic']:.0f}",
    }


def _interval(spread: Spread, factor: float = 1.0) -> dict:
    interval = ""
    if not math.isnan(spread.lower):
        low, high = factor * spread.lower, factor * spread.upper
        interval = f"{low:.3g} to {high:.3g}"
    return {"value": f"{factor * spread.value:.4g}", "interval": interval}


def _cell(value) -> str:
    return "" if value is None else f"{value:.4g}"


def _uri(png: bytes) -> str:
    text = base64.b64encode(png).decode("ascii")
    return f"data:image/png;base64,{text}"

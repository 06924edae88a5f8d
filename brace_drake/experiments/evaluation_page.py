"""An evaluation as one HTML file that needs nothing else."""

from __future__ import annotations

import base64
from pathlib import Path

from brace_drake.core.output import WriteText
from brace_drake.experiments.evaluate import Evaluation
from brace_drake.experiments.evaluation_table import (
    COLUMNS,
    summarize,
    table_1,
)
from brace_drake.experiments.evaluation_words import explain
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
    text = render_template(
        _TEMPLATE,
        Path(__file__).parent,
        evaluation=evaluation,
        sentences=explain(evaluation),
        columns=COLUMNS,
        nominal=table_1(evaluation),
        unseen=summarize(evaluation),
        figures=[(_CAPTIONS[name], _uri(figures[name])) for name in _CAPTIONS],
        picture=_uri(figures["unseen"]),
    )
    WriteText(folder / "evaluation.html", text)


def _uri(png: bytes) -> str:
    text = base64.b64encode(png).decode("ascii")
    return f"data:image/png;base64,{text}"

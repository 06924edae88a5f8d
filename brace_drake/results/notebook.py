"""Results as notebooks show them: a few lines of HTML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from brace_drake.report.page import render_template
from brace_drake.report.words import parameter_row


def _render(name: str, **values: Any) -> str:
    return render_template(name, Path(__file__).parent, **values)


def render_diagnosis(document: Mapping[str, Any]) -> str:
    """Verdict, effects with their parameters, and the gap before and after."""
    verdict = document["verdict"]
    supported = [
        row | {"parameters": [parameter_row(p) for p in row["parameters"]]}
        for row in verdict["supported"]
    ]
    return _render(
        "diagnosis.html.j2",
        verdict=verdict,
        supported=supported,
        shrink=document["shrink"],
        warnings=document["warnings"],
        scenario=document["provenance"].get("scenario"),
    )


def render_fit(document: Mapping[str, Any]) -> str:
    """The parameters with their intervals."""
    rows = [parameter_row(p) for p in document["parameters"]]
    return _render("fit.html.j2", fit=document, rows=rows)


def render_plan(document: Mapping[str, Any]) -> str:
    """The pairs of effects that are not told apart."""
    return _render("plan.html.j2", plan=document)

"""The causes of a page: those searched, those the same, those left open."""

from __future__ import annotations

from brace_drake.report.cards import name_of, parts_of
from brace_drake.report.words import (
    NOTHING,
    parameter_row,
    percent,
    to_number,
)


def view_causes(causes: list[dict], verdict: dict) -> dict:
    """Rows of the table of causes, and what stands apart from it."""
    searched = [c for c in causes if c["searched"] and not c["same_as"]]
    return {
        "searched": [_row(cause, causes) for cause in searched],
        "screened": [c["effect"] for c in causes if not c["searched"]],
        **_open_causes(causes, verdict),
    }


def _row(cause: dict, causes: list[dict]) -> dict:
    """A cause with what is shown of it; a fit that was stopped early leaves at
    most what it left then.
    """
    share = percent(cause["explained"])
    if not cause["converged"]:
        # At least nothing says nothing.
        share = NOTHING if share == "0 %" else f"≥ {share}"
    same = [c for c in causes if c["same_as"] == cause["effect"]]
    return cause | {
        "parameters": [parameter_row(p) for p in cause["parameters"]],
        "share": share,
        "same": [
            {
                "effect": c["effect"],
                "parameters": [parameter_row(p) for p in c["parameters"]],
            }
            for c in same
        ],
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
        and not c["same_as"]
        and not {name_of(p) for p in parts_of(c["effect"])} <= chosen
    ]
    far = [c for c in unconverged if to_number(c["explained"]) < most]
    return {
        "unconverged": [c["effect"] for c in unconverged if c not in far],
        "left_early": [c["effect"] for c in far],
    }

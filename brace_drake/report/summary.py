"""Many campaigns in one table, as a page and as a file for spreadsheets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from brace_drake.core.csv_text import csv_text
from brace_drake.core.output import WriteFiles
from brace_drake.report.certain import BADGES, kind_of
from brace_drake.report.page import render_template
from brace_drake.report.words import percent_interval

COLUMNS = (
    "campaign",
    "verdict",
    "effects",
    "probability",
    "blocks",
    "ambiguous_with",
    "gap_before",
    "gap_after",
    "closed",
    "closed_lower95",
    "closed_upper95",
    "report",
    "error",
)
_EMPTY = dict.fromkeys(COLUMNS, "")


def summary_row(name: str, document: dict) -> dict:
    """One campaign's row from its diagnosis, COLUMNS as keys.

    Args:
        name: Of the campaign and of its folder beside the summary.
        document: Content of its diagnosis.json.
    """
    verdict, shrink = document["verdict"], document["shrink"] or {}
    low, high = shrink.get("closed_interval") or (None, None)
    numbers = {
        "probability": verdict["probability"],
        "gap_before": shrink.get("before"),
        "gap_after": shrink.get("after"),
        "closed": shrink.get("closed"),
        "closed_lower95": low,
        "closed_upper95": high,
    }
    known = {key: v for key, v in numbers.items() if v is not None}
    return (
        _EMPTY
        | known
        | {
            "campaign": name,
            "verdict": BADGES[kind_of(verdict)].lower(),
            "effects": "+".join(verdict["effects"]),
            "blocks": "+".join(verdict["blocks"]),
            "ambiguous_with": ", ".join(verdict["ambiguous_with"]),
            "report": f"{name}/report.html",
        }
    )


def failed_row(name: str, error: str) -> dict:
    """The row of a campaign that could not be diagnosed, and why."""
    return _EMPTY | {"campaign": name, "verdict": "failed", "error": error}


def WriteSummary(folder: Path, rows: Sequence[dict]) -> None:
    """Writes summary.csv and summary.html into a folder.

    Raises:
        OutputError: The place cannot be written.
    """
    WriteFiles(
        {
            folder / "summary.csv": csv_text(COLUMNS, rows),
            folder / "summary.html": render_summary(rows),
        }
    )


def render_summary(rows: Sequence[dict]) -> str:
    """The page as HTML text."""
    return render_template(
        "summary.html.j2", rows=[_shown(r) for r in rows], counts=_counts(rows)
    )


def _shown(row: dict) -> dict:
    # A cell without a number is empty in the file, and None for the page.
    cells = {key: None if v == "" else v for key, v in row.items()}
    ends = cells["closed_lower95"], cells["closed_upper95"]
    return cells | {
        "link": quote(row["report"]),
        "tone": _TONES[row["verdict"]],
        "effects": [e for e in row["effects"].split("+") if e],
        "ambiguous": [n for n in row["ambiguous_with"].split(", ") if n],
        "blocks": row["blocks"].replace("+", ", "),
        "interval": percent_interval(cells["closed"], *ends)[1],
    }


_TONES = {badge.lower(): kind for kind, badge in BADGES.items()}
_TONES["failed"] = "failed"


def _counts(rows: Sequence[dict]) -> list[tuple[str, int]]:
    kinds = [r["verdict"] for r in rows]
    return [(k, kinds.count(k)) for k in dict.fromkeys(kinds)]

"""Many campaigns in one table, as a page and as a file for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from brace_drake.core.output import WriteText
from brace_drake.report.access import bar_width, items, names, part, text
from brace_drake.report.words import percent, percent_interval, times, to_number

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
        document: Content of its diagnosis.json; any part may be missing.
    """
    verdict, shrink = part(document, "verdict"), part(document, "shrink")
    interval = [*items(shrink, "closed_interval"), None, None]
    return _EMPTY | {
        "campaign": name,
        "verdict": _kind(verdict),
        "effects": "+".join(names(verdict, "effects")),
        "probability": _number(verdict.get("probability")),
        "blocks": "+".join(names(verdict, "blocks")),
        "ambiguous_with": " ".join(names(verdict, "ambiguous_with")),
        "gap_before": _number(shrink.get("before")),
        "gap_after": _number(shrink.get("after")),
        "closed": _number(shrink.get("closed")),
        "closed_lower95": _number(interval[0]),
        "closed_upper95": _number(interval[1]),
        "report": f"{name}/report.html",
    }


def failed_row(name: str, error: str) -> dict:
    """The row of a campaign that could not be diagnosed, and why."""
    return _EMPTY | {"campaign": name, "verdict": "failed", "error": error}


def WriteSummary(folder: Path, rows: Sequence[dict]) -> None:
    """Writes summary.csv and summary.html into a folder.

    Raises:
        OutputError: The place cannot be written.
    """
    table = io.StringIO()
    writer = csv.DictWriter(table, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    WriteText(folder / "summary.csv", table.getvalue())
    WriteText(folder / "summary.html", render_summary(rows))


def render_summary(rows: Sequence[dict]) -> str:
    """The page as HTML text."""
    from jinja2 import Environment, FileSystemLoader

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    template = environment.get_template("summary.html.j2")
    return template.render(rows=[_shown(r) for r in rows], counts=_counts(rows))


def _kind(verdict: dict) -> str:
    if verdict.get("outside_library"):
        return "outside the library"
    if verdict.get("gap") is None:
        return "none reached"
    return "gap" if verdict["gap"] else "no gap"


def _number(value: object) -> float | str:
    number = to_number(value)
    return number if number == number else ""


def _shown(row: dict) -> dict:
    ends = (row["closed_lower95"], row["closed_upper95"])
    _, interval = percent_interval(row["closed"], *ends)
    return {
        "campaign": row["campaign"],
        "link": quote(row["report"]),
        "kind": row["verdict"],
        "tone": _TONES.get(row["verdict"], "unknown"),
        "effects": [e for e in row["effects"].split("+") if e],
        "ambiguous": row["ambiguous_with"].split(),
        "probability": percent(row["probability"]),
        "blocks": row["blocks"].replace("+", ", "),
        "before": times(row["gap_before"]),
        "after": times(row["gap_after"]),
        "closed": percent(row["closed"]),
        "width": bar_width(row["closed"]),
        "interval": interval,
        "error": text(row, "error"),
    }


_TONES = {
    "gap": "gap",
    "no gap": "none",
    "outside the library": "outside",
    "failed": "failed",
}


def _counts(rows: Sequence[dict]) -> list[tuple[str, int]]:
    kinds = [r["verdict"] for r in rows]
    return [(k, kinds.count(k)) for k in dict.fromkeys(kinds)]

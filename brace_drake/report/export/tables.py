"""The tables of a diagnosis as files, CSV or LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from brace_drake.core.csv_text import csv_text
from brace_drake.core.output import MakeFolder, WriteFiles
from brace_drake.report.words import to_text

FORMATS = ("csv", "latex")
FOLDER = "tables"
_ENDINGS = {"csv": "csv", "latex": "tex"}
_ESTIMATE = ("value", "standard_error", "lower95", "upper95", "unit")
_SPECIAL = {c: f"\\{c}" for c in "&%$#_{}"} | {
    "\\": "\\textbackslash{}",
    "~": "\\textasciitilde{}",
    "^": "\\textasciicircum{}",
    "−": "$-$",
    "×": "$\\times$",
    "–": "--",
}
Table = tuple[Sequence[str], list[list]]


def WriteTables(diagnosis: dict, folder: Path, form: str) -> list[Path]:
    """Writes the tables of a diagnosis into `tables/`.

    CSV has the numbers of diagnosis.json as they are, an empty cell for none;
    LaTeX is a `tabular` of rounded ones that needs no package.

    Args:
        diagnosis: Content of diagnosis.json.
        folder: Of the results.
        form: One of FORMATS.

    Returns:
        The files.

    Raises:
        OutputError: The place cannot be written.
    """
    place = MakeFolder(folder / FOLDER)
    files = {
        place / f"{name}.{_ENDINGS[form]}": csv_text(*table)
        if form == "csv"
        else latex_text(table)
        for name, table in make_tables(diagnosis).items()
        if table[1]
    }
    WriteFiles(files)
    return [*files]


def make_tables(diagnosis: dict) -> dict[str, Table]:
    """Columns and rows by name."""
    where, shrink = diagnosis["where"], diagnosis["shrink"] or {}
    verdict, subject = diagnosis["verdict"], diagnosis["subject"]
    named = verdict["supported"]
    law = verdict["unexplained"]["law"] or {"terms": []}
    shares = ("probability", "closes")
    interval = ("closes_lower95", "closes_upper95")
    numbers = ("name", "value", "standard_error", "unit")
    return {
        "effects": (
            ("effect", "block", *shares, *interval),
            [
                [
                    *(r[key] for key in ("effect", "block", *shares)),
                    *(r["closes_interval"] or (None, None)),
                ]
                for r in named
            ],
        ),
        "effect_parameters": _estimates(
            "effect",
            [(r["effect"], r["parameters"]) for r in verdict["supported"]],
        ),
        "law": (
            ("term", "formula", *numbers),
            [
                [t["text"], t["formula"], *(p[key] for key in numbers)]
                for t in law["terms"]
                for p in t["parameters"]
            ],
        ),
        "causes": _pick(
            [c for c in diagnosis["causes"] if c["searched"]],
            ("effect", "block", "chosen", "converged", "score", "explained"),
            ("held_out", "same_as", "decision"),
        ),
        "subject": _estimates(
            "device",
            [(diagnosis["device"], subject["parameters"])],
        ),
        "validation_channels": _pick(
            shrink.get("channels", []),
            ("channel", "before", "after", "floor", "closed"),
        ),
        "runs": _pick(
            diagnosis["runs"],
            ("run", "motion", "split", "contact", "repeat_of", "duration_s"),
            ("samples", "rate_hz", "before", "after", "with_law"),
        ),
        "power_by_block": _pick(
            where["attribution"], ("block", "share", "lower95", "upper95")
        ),
        "block_tests": _pick(
            where["blocks"],
            ("block", "normalised_rms", "threshold", "acquitted"),
        ),
        "channels": _pick(
            where["channels"],
            ("channel", "unit", "floor", "before", "after", "share"),
        ),
        "phases": _pick(where["phases"], ("phase", "before", "after", "share")),
        "bands": _pick(
            where["bands"], ("from_Hz", "to_Hz", "before", "after", "share")
        ),
    }


def _pick(rows: Sequence[dict], *columns: Sequence[str]) -> Table:
    names = [name for part in columns for name in part]
    return names, [[row[name] for name in names] for row in rows]


def _estimates(first: str, groups: Sequence[tuple[str, list]]) -> Table:
    """Parameters with their errors, behind the name of what has them."""
    return (first, "parameter", *_ESTIMATE), [
        [name, p["name"], *(p[key] for key in _ESTIMATE)]
        for name, parameters in groups
        for p in parameters
    ]


def latex_text(table: Table) -> str:
    """A tabular of rounded numbers."""
    columns, rows = table
    is_number = [
        all(_is_number(row[i]) or row[i] is None for row in rows)
        for i in range(len(columns))
    ]
    layout = "".join("r" if number else "l" for number in is_number)
    lines = [f"\\begin{{tabular}}{{{layout}}}", "\\hline"]
    lines += [_latex_row([c.replace("_", " ") for c in columns]), "\\hline"]
    lines += [_latex_row(row) for row in rows]
    return "\n".join([*lines, "\\hline", "\\end{tabular}", ""])


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _latex_row(cells: Sequence) -> str:
    return " & ".join(_latex_cell(cell) for cell in cells) + " \\\\"


def _latex_cell(value: object) -> str:
    text = f"{value:.4g}" if isinstance(value, float) else to_text(value)
    if _is_number(value):
        text = text.replace("-", "−")
    return "".join(_SPECIAL.get(c, c) for c in text)

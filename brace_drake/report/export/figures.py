"""The figures of a report as files."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from brace_drake.core.output import MakeFolder, WriteBytes
from brace_drake.report.canvas import WIDTH
from brace_drake.report.figures.bars import (
    draw_blocks,
    draw_correlation,
    draw_pairs,
)
from brace_drake.report.figures.budget import draw_attribution, draw_power
from brace_drake.report.figures.law import draw_law
from brace_drake.report.figures.traces import draw_plane, draw_trace
from brace_drake.report.law_curve import LawCurve
from brace_drake.report.traces import RunTrace, most_telling
from brace_drake.report.words import band_text, channel_text, parameter_row

FORMATS = ("svg", "png", "pdf")
FOLDER = "figures"
_DPI = 200
# What would make two files of the same figure differ.
_NO_DATES: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def WriteFigures(
    diagnosis: dict,
    traces: Sequence[RunTrace],
    laws: Sequence[LawCurve],
    folder: Path,
    form: str,
) -> list[Path]:
    """Writes every figure that a report has into `figures/`.

    Args:
        diagnosis: Content of diagnosis.json.
        traces, laws: As for the report.
        folder: Of the results.
        form: One of FORMATS.

    Returns:
        The files.

    Raises:
        OutputError: The place cannot be written.
    """
    place, written = MakeFolder(folder / FOLDER), []
    encode = partial(figure_bytes, form=form)
    for name, draw, drawn in _figures(diagnosis, traces, laws):
        content = draw(*drawn, encode=encode)
        if content is None:
            continue
        path = place / f"{name}.{form}"
        WriteBytes(path, content)
        written.append(path)
    return written


def figure_bytes(figure, form: str) -> bytes:
    """A figure as the content of a file; the same for the same figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format=form, dpi=_DPI, metadata=_NO_DATES[form])
    return buffer.getvalue()


def _figures(
    diagnosis: dict, traces: Sequence[RunTrace], laws: Sequence[LawCurve]
) -> Iterator[tuple[str, Callable[..., Any], tuple]]:
    """Names, what draws each of them, and from what."""
    where, subject = diagnosis["where"], diagnosis["subject"]
    told = most_telling(traces)
    if told is not None:
        first = traces[told[0]]
        yield "gap", draw_trace, (first, told[1])
        yield "gap_against_motion", draw_plane, (first,)
    for trace in traces:
        yield f"run_{_plain_name(trace.name)}", draw_trace, (trace,)
    for i, law in enumerate(laws, start=1):
        yield f"law_{i}", draw_law, (law,)
    yield "power_by_block", draw_attribution, (where["attribution"],)
    yield "power_by_channel", draw_power, (where["cube"],)
    yield "block_tests", draw_blocks, (where["blocks"],)
    for key, names in (
        ("channels", [channel_text(r["channel"]) for r in where["channels"]]),
        ("phases", [row["phase"] for row in where["phases"]]),
        ("bands", [band_text(row) for row in where["bands"]]),
    ):
        yield key, draw_pairs, (names, where[key], WIDTH)
    names = [parameter_row(p)["name"] for p in subject["parameters"]]
    yield "correlation", draw_correlation, (names, subject["correlation"])


def _plain_name(name: str) -> str:
    """A run's name as part of that of a file."""
    return re.sub(r"[^\w.-]+", "_", name) or "run"

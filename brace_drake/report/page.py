"""Writes the report as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from brace_drake.core.errors import OutputError
from brace_drake.core.output import WriteBytes
from brace_drake.report.traces import RunTrace
from brace_drake.report.view import make_view

_TEMPLATE = "template.html.j2"


def WriteReport(
    diagnosis: dict, traces: Sequence[RunTrace], path: str | Path
) -> None:
    """Writes the report of a diagnosis.

    The file appears under its name only when it is complete; folders on the
    way to it are made.

    Args:
        diagnosis: Content of diagnosis.json; any part may be missing.
        traces: Runs to show. Those of the validation split are drawn, those
            of the fit split only where there are no others.
        path: Of the HTML file.

    Raises:
        OutputError: The place cannot be written.
    """
    path = Path(path).absolute()
    page = render_page(diagnosis, traces)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{path}: cannot be written: {error.strerror}"
        ) from error
    WriteBytes(path, page.encode("utf-8", errors="replace"))


def render_page(diagnosis: dict, traces: Sequence[RunTrace]) -> str:
    """The report as HTML text."""
    from jinja2 import Environment, FileSystemLoader

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    view = make_view(diagnosis, traces)
    return environment.get_template(_TEMPLATE).render(**view)

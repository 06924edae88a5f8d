"""Writes the report as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from brace_drake.core.output import MakeFolder, WriteBytes
from brace_drake.report import words
from brace_drake.report.traces import RunTrace
from brace_drake.report.view import make_view

# How the templates show a number or a name, as filters.
_FILTERS = (
    words.band_text,
    words.bar_width,
    words.channel_text,
    words.fixed,
    words.floor_text,
    words.over_floor,
    words.percent,
    words.significant,
    words.times,
    words.to_text,
)


def WriteReport(
    diagnosis: dict, traces: Sequence[RunTrace], path: str | Path
) -> None:
    """Writes the report of a diagnosis.

    The file appears under its name only when it is complete; folders on the
    way to it are made.

    Args:
        diagnosis: Content of diagnosis.json.
        traces: Runs to show. Those of the validation split are drawn, those
            of the fit split only where there are no others.
        path: Of the HTML file.

    Raises:
        OutputError: The place cannot be written.
    """
    path = Path(path).absolute()
    page = render_page(diagnosis, traces)
    MakeFolder(path.parent)
    WriteBytes(path, page.encode("utf-8", errors="replace"))


def render_page(diagnosis: dict, traces: Sequence[RunTrace]) -> str:
    """The report as HTML text."""
    view = make_view(diagnosis, traces)
    return render_template("template.html.j2", **view)


def render_template(name: str, *folders: Path, **values) -> str:
    """A template of one of the folders, or of this one, filled in."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader((*folders, Path(__file__).parent)),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    environment.filters |= {f.__name__: f for f in _FILTERS}
    environment.globals |= {
        "nothing": words.NOTHING,
        "percent_interval": words.percent_interval,
    }
    return environment.get_template(name).render(**values)

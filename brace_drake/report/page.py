"""Writes the report as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

from brace_drake.core.output import MakeFolder, WriteBytes
from brace_drake.report import words
from brace_drake.report.law_curve import LawCurve
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
    diagnosis: dict,
    traces: Sequence[RunTrace],
    path: str | Path,
    laws: Sequence[LawCurve] = (),
) -> None:
    """Writes the report of a diagnosis.

    The file appears under its name only when it is complete; folders on the
    way to it are made.

    Args:
        diagnosis: Content of diagnosis.json.
        traces: Runs to show, in the order of the page.
        path: Of the HTML file.
        laws: Of what is left, to be drawn.

    Raises:
        OutputError: The place cannot be written.
    """
    path = Path(path).absolute()
    page = render_page(diagnosis, traces, laws)
    MakeFolder(path.parent)
    WriteBytes(path, page.encode("utf-8", errors="replace"))


def render_page(
    diagnosis: dict,
    traces: Sequence[RunTrace],
    laws: Sequence[LawCurve] = (),
) -> str:
    """The report as HTML text."""
    view = make_view(diagnosis, traces, laws)
    return render_template("template.html.j2", **view)


def render_template(name: str, *folders: Path, **values) -> str:
    """A template of one of the folders, or of this one, filled in."""
    return _environment(folders).get_template(name).render(**values)


@cache
def _environment(folders: tuple[Path, ...]):
    """What finds templates; it keeps those that it has read."""
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
    return environment

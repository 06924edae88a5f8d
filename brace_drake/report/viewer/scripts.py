"""Script and style of the viewer, as they go into the page."""

from __future__ import annotations

from functools import cache
from pathlib import Path

_HERE = Path(__file__).parent
_LIBRARY = _HERE / "uplot"


@cache
def viewer_script() -> str:
    """uPlot under its licence, then the viewer."""
    licence = (_LIBRARY / "LICENSE").read_text("utf-8").strip()
    library = (_LIBRARY / "uPlot.iife.min.js").read_text("utf-8").strip()
    own = (_HERE / "viewer.js").read_text("utf-8").strip()
    return f"/*!\n{licence}\n*/\n{library}\n{own}\n"


@cache
def viewer_style() -> str:
    """uPlot's style, then the viewer's."""
    library = (_LIBRARY / "uPlot.min.css").read_text("utf-8").strip()
    own = (_HERE / "viewer.css").read_text("utf-8").strip()
    return f"{library}\n{own}\n"

"""The look of all figures, and their way into the page."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numpy as np

# Okabe and Ito's colours, told apart by any reader, and greys.
MEASURED = "#1f2933"
BEFORE = "#d55e00"
AFTER = "#0072b2"
LAW = "#00785a"
ACQUITTED = "#b4bcc6"
FLOOR = "#6b7785"
RULE = "#dde2e8"

# Inches of the page's full width.
WIDTH = 9.4

# What becomes of a figure: text for a page, or the content of a file.
Encode = Callable[[Any], Any]

# Of a picture that a page holds many of.
_COLOURS, _DPI = 48, 110

_FONTS = ("Helvetica Neue", "Arial", "Liberation Sans")
# Comes with matplotlib and has the signs that others lack.
_WIDEST_FONT = "DejaVu Sans"


@cache
def _font() -> str:
    from matplotlib import font_manager

    there = {font.name for font in font_manager.fontManager.ttflist}
    return next((name for name in _FONTS if name in there), _WIDEST_FONT)


@contextmanager
def figure_style() -> Iterator[None]:
    """The settings of all figures, for as long as the context lasts."""
    import matplotlib

    settings: Any = {
        "font.family": [_font(), _WIDEST_FONT],
        "font.size": 9.0,
        "text.color": MEASURED,
        "text.usetex": False,
        "axes.edgecolor": ACQUITTED,
        "axes.labelcolor": "#46525f",
        "axes.labelsize": 8.5,
        "axes.linewidth": 0.8,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.unicode_minus": True,
        "axes.axisbelow": True,
        "axes.titlesize": 9.0,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "xtick.color": "#46525f",
        "ytick.color": "#46525f",
        "xtick.labelsize": 8.5,
        "ytick.labelsize": 8.5,
        "grid.color": RULE,
        "grid.linewidth": 0.7,
        "legend.frameon": False,
        "legend.fontsize": 8.5,
        "svg.fonttype": "path",
        # Text of a PDF can be searched and copied.
        "pdf.fonttype": 42,
        # The same diagnosis gives the same file.
        "svg.hashsalt": "brace_drake",
    }
    with matplotlib.rc_context(settings):
        yield


class Margins(NamedTuple):
    """Around and between panels one above the other, inches."""

    left: float
    right: float
    top: float
    bottom: float
    between: float


def make_figure(width: float, height: float):
    """An empty figure on the Agg canvas, inches, outside of pyplot."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    engine = ConstrainedLayoutEngine(w_pad=0.02, h_pad=0.04)
    return _empty_figure(width, height, engine)


def _empty_figure(width: float, height: float, layout):
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout=layout)
    FigureCanvasAgg(figure)
    return figure


def make_stack(width: float, heights: Sequence[float], margins: Margins):
    """A figure and its panels, one above the other, with a common time.

    For figures that a page has many of: a layout as texts need it takes as
    long as the drawing.
    """
    between = margins.between * (len(heights) - 1)
    height = margins.top + sum(heights) + between + margins.bottom
    figure = _empty_figure(width, height, None)
    panels: list = []
    top = height - margins.top
    for own in heights:
        box = (
            margins.left / width,
            (top - own) / height,
            1.0 - (margins.left + margins.right) / width,
            own / height,
        )
        panels.append(
            figure.add_axes(box, sharex=panels[0] if panels else None)
        )
        top -= own + margins.between
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    return figure, panels


def to_data_uri(figure) -> str:
    """The figure as an SVG inside a data URI; dense lines are rasterised."""
    buffer = io.BytesIO()
    figure.savefig(
        buffer,
        format="svg",
        dpi=200,
        transparent=True,
        metadata={"Date": None, "Creator": None},
    )
    text = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f"data:image/svg+xml;base64,{text}"


def to_png_uri(figure) -> str:
    """The figure as a PNG of few colours inside a data URI: small, for what a
    page holds many of.
    """
    from PIL import Image

    figure.set_dpi(_DPI)
    figure.canvas.draw()
    small = io.BytesIO()
    picture = Image.fromarray(np.asarray(figure.canvas.buffer_rgba()))
    picture.convert("RGB").quantize(_COLOURS).save(small, "PNG")
    text = base64.b64encode(small.getvalue()).decode("ascii")
    return f"data:image/png;base64,{text}"


def plain(text: object) -> str:
    """Text that matplotlib takes as it is, without mathematics."""
    printable = "".join(c if c.isprintable() else " " for c in str(text))
    return printable.replace("$", r"\$")


def shorten(text: object, most: int = 34) -> str:
    """Plain text, cut in its middle where it is longer than `most`."""
    text = str(text)
    if len(text) > most:
        text = f"{text[: most - 12]}…{text[-11:]}"
    return plain(text)

"""Time traces: measured, before and after, and what is left of the gap."""

from __future__ import annotations

import numpy as np

from brace_drake.recording.columns import split_unit
from brace_drake.report.canvas import (
    AFTER,
    BEFORE,
    FLOOR,
    WIDTH,
    figure_style,
    make_figure,
    plain,
    to_data_uri,
)
from brace_drake.report.traces import RunTrace
from brace_drake.report.words import NOTHING, channel_text, scale_of, times

# Half-width of the floor's band, in standard deviations.
_BAND = 2.0

_PALE = "#b3bcc6"


def draw_trace(trace: RunTrace) -> str | None:
    """Panels of one run as a data URI; None when nothing can be drawn.

    The force along the correction with its residual, then the residual of the
    channel with the largest normalised gap among the others.
    """
    main = trace.main_channel()
    if main is None:
        return None
    other = trace.worst_channel(leave_out=main)
    with figure_style():
        heights = [1.9, 1.15] + [1.15] * (other is not None)
        figure = make_figure(WIDTH, sum(heights) + 0.75)
        panels = figure.subplots(
            len(heights), sharex=True, height_ratios=heights, squeeze=False
        )[:, 0]
        _draw_values(panels[0], trace, main)
        _draw_residual(panels[1], trace, main)
        if other is not None:
            _draw_residual(panels[2], trace, other)
        panels[-1].set_xlabel("time, s")
        time = np.asarray(trace.time_s, dtype=float)
        span = time[np.isfinite(time)]
        if len(span) and span.min() < span.max():
            panels[0].set_xlim(span.min(), span.max())
        _draw_legend(figure, trace)
        return to_data_uri(figure)


def _draw_values(axes, trace: RunTrace, c: int) -> None:
    name = trace.channels[c]
    factor, unit = _scale(trace.measured[:, c], name)
    # Measured is a wide pale line, so that it shows under a good prediction.
    lines = [(trace.measured, _PALE, 3.6), (trace.before, BEFORE, 1.1)]
    if trace.after is not None:
        lines.append((trace.after, AFTER, 1.1))
    for values, color, width in lines:
        _draw_line(axes, trace.time_s, values[:, c] * factor, color, width)
    axes.set_title(plain(f"{channel_text(name)}, {unit}"))
    axes.grid(axis="y")


def _draw_residual(axes, trace: RunTrace, c: int) -> None:
    name = trace.channels[c]
    before = trace.measured[:, c] - trace.before[:, c]
    factor, unit = _scale(before, name)
    band = _BAND * float(trace.floor_rms[c]) * factor
    if np.isfinite(band):
        axes.axhspan(-band, band, color=FLOOR, alpha=0.16, lw=0)
        for edge in (-band, band):
            axes.axhline(edge, color=FLOOR, lw=0.7, ls=(0, (4, 2)), zorder=3)
    axes.axhline(0.0, color=FLOOR, lw=0.6)
    _draw_line(axes, trace.time_s, before * factor, BEFORE, 0.9)
    note = f"before {_gap(trace, trace.before, c)}"
    if trace.after is not None:
        after = trace.measured[:, c] - trace.after[:, c]
        _draw_line(axes, trace.time_s, after * factor, AFTER, 0.9)
        note += f", after {_gap(trace, trace.after, c)}"
    axes.set_title(
        plain(f"{channel_text(name)}: measured minus predicted, {unit}")
    )
    axes.set_title(
        f"{note} × floor", loc="right", fontsize=8.5, fontweight="normal"
    )
    axes.grid(axis="y")


def _gap(trace: RunTrace, predicted: np.ndarray, c: int) -> str:
    return times(float(trace.normalised_rms(predicted)[c])) or NOTHING


def _draw_line(axes, time, values, color: str, width: float) -> None:
    axes.plot(time, values, color=color, lw=width, rasterized=True)


def _scale(values: np.ndarray, name: str) -> tuple[float, str]:
    unit = split_unit(name)[1]
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if len(finite) else 0.0
    return scale_of(unit, [largest])


def _draw_legend(figure, trace: RunTrace) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [
        Line2D([], [], color=_PALE, lw=3.6, label="measured"),
        Line2D([], [], color=BEFORE, lw=1.8, label="before"),
        Line2D([], [], color=AFTER, lw=1.8, label="after"),
        Patch(color=FLOOR, alpha=0.25, lw=0, label="±2 noise floor"),
    ]
    if trace.after is None:
        del handles[2]
    figure.legend(
        handles=handles,
        loc="outside upper left",
        ncols=4,
        handlelength=1.4,
        borderaxespad=0.0,
    )

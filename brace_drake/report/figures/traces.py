"""Runs: time traces, the residual against motion, and its spectrum."""

from __future__ import annotations

from typing import Any

import numpy as np

from brace_drake.core.cosine_transform import frequencies_of, to_frequency
from brace_drake.recording.columns import split_unit
from brace_drake.report.canvas import (
    AFTER,
    BEFORE,
    FLOOR,
    LAW,
    WIDTH,
    Encode,
    Margins,
    figure_style,
    make_figure,
    make_stack,
    plain,
    to_png_uri,
)
from brace_drake.report.traces import RunTrace
from brace_drake.report.words import channel_text, scale_of, times

# Half-width of the floor's band, in standard deviations.
_BAND = 2.0
_MOST_POINTS = 4000
# Ticks and a title, and above all the legend.
_AROUND = Margins(left=0.62, right=0.14, top=0.52, bottom=0.46, between=0.3)
# Noise of single samples would hide a loop, s.
_PLANE_S = 0.2
# Least bins of the spectrum in one point of its curve.
_SMOOTHING_HZ = 0.15

_PALE = "#b3bcc6"
COLORS = {"before": BEFORE, "after": AFTER, "law": LAW}
NAMES = {
    "before": "twin before the repair",
    "after": "twin after the repair",
    "law": "and with the law of what is left",
}
_SHORT = {"before": "before", "after": "after", "law": "with the law"}


def draw_trace(
    trace: RunTrace,
    channel: int | None = None,
    encode: Encode | None = None,
) -> Any:
    """Panels of one run as a data URI; None when nothing can be drawn.

    The force along the correction with its residual, then the residual of the
    channel with the largest normalised gap among the others.

    Args:
        trace: Of the run.
        channel: The only one to be drawn, in place of both.
        encode: Makes of the figure what is returned.
    """
    main = trace.main_channel() if channel is None else channel
    if main is None:
        return None
    other = trace.worst_channel(leave_out=main) if channel is None else None
    with figure_style():
        heights = [1.6, 0.9] + [0.9] * (other is not None)
        figure, panels = make_stack(WIDTH, heights, _AROUND)
        draw_values(panels[0], trace, main)
        draw_residual(panels[1], trace, main)
        if other is not None:
            draw_residual(panels[2], trace, other)
        panels[-1].set_xlabel("time, s")
        panels[0].set_xlim(trace.time_s[0], trace.time_s[-1])
        _draw_legend(figure, trace)
        return (encode or to_png_uri)(figure)


def draw_plane(trace: RunTrace, encode: Encode | None = None) -> Any:
    """Residual against depth and rate, and spectrum, as a data URI.

    None where the run is short or its force was not recorded throughout.
    """
    c = trace.main_channel()
    if c is None or len(trace.time_s) < 32:
        return None
    lines = [
        (trace.measured[:, c] - twin[:, c], COLORS[kind])
        for kind, twin in trace.twins()
    ]
    if not all(np.isfinite(v).all() for v, _ in lines):
        return None
    step = float(np.median(np.diff(trace.time_s)))
    has_motion = trace.position is not None
    with figure_style():
        figure = make_figure(WIDTH, 2.5)
        panels = figure.subplots(1, 3 if has_motion else 1, squeeze=False)[0]
        if has_motion:
            _draw_planes(panels, trace, lines, c, step)
        _draw_spectrum(panels[-1], trace, lines, c, step)
        return (encode or to_png_uri)(figure)


def draw_values(axes, trace: RunTrace, c: int) -> None:
    name = trace.channels[c]
    factor, unit = _scale(trace.measured[:, c], name)
    # Measured is a wide pale line, so that it shows under a good prediction.
    lines = [(trace.measured, _PALE, 3.6)]
    lines += [(twin, COLORS[kind], 1.1) for kind, twin in trace.twins()]
    for values, color, width in lines:
        _draw_line(axes, trace.time_s, values[:, c] * factor, color, width)
    axes.set_title(plain(f"{channel_text(name)}, {unit}"))
    axes.grid(axis="y")


def draw_residual(axes, trace: RunTrace, c: int) -> None:
    name = trace.channels[c]
    before = trace.measured[:, c] - trace.before[:, c]
    factor, unit = _scale(before, name)
    band = _BAND * float(trace.floor_rms[c]) * factor
    axes.axhspan(-band, band, color=FLOOR, alpha=0.16, lw=0)
    for edge in (-band, band):
        axes.axhline(edge, color=FLOOR, lw=0.7, ls=(0, (4, 2)), zorder=3)
    axes.axhline(0.0, color=FLOOR, lw=0.6)
    notes = []
    for kind, twin in trace.twins():
        residual = (trace.measured[:, c] - twin[:, c]) * factor
        _draw_line(axes, trace.time_s, residual, COLORS[kind], 0.9)
        notes.append(f"{_SHORT[kind]} {_gap(trace, twin, c)}")
    axes.set_title(plain(f"{channel_text(name)}: measured minus twin, {unit}"))
    axes.set_title(
        f"{', '.join(notes)} × floor",
        loc="right",
        fontsize=8.5,
        fontweight="normal",
    )
    axes.grid(axis="y")


def _gap(trace: RunTrace, predicted: np.ndarray, c: int) -> str:
    return times(float(trace.normalised_rms(predicted)[c]))


def _draw_line(axes, time, values, color: str, width: float) -> None:
    axes.plot(time, values, color=color, lw=width)


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
        *(
            Line2D([], [], color=COLORS[kind], lw=1.8, label=NAMES[kind])
            for kind, _ in trace.twins()
        ),
        Patch(color=FLOOR, alpha=0.25, lw=0, label="±2 × noise floor"),
    ]
    figure.legend(
        handles=handles,
        loc="upper left",
        ncols=5,
        handlelength=1.4,
        borderaxespad=0.3,
    )


def _draw_planes(panels, trace: RunTrace, lines, c: int, step: float) -> None:
    width = round(_PLANE_S / step)
    depth = _smooth(1e3 * np.asarray(trace.position, dtype=float), width)
    rate = np.gradient(_smooth(depth, width), step)
    # The moving average folds at both ends.
    inner = slice(width, len(depth) - width)
    every = max(1, len(depth) // _MOST_POINTS)
    unit = trace.channels[c].rsplit("_", 1)[-1]
    for axes, x, label in (
        (panels[0], depth, f"{trace.position_name}, mm"),
        (panels[1], rate, "its rate, mm/s"),
    ):
        axes.axhline(0.0, color=FLOOR, lw=0.6)
        for residual, color in lines:
            axes.plot(
                x[inner][::every],
                _smooth(residual, width)[inner][::every],
                color=color,
                lw=0.9,
            )
        axes.set_xlabel(plain(label))
        axes.grid()
    name = channel_text(trace.channels[c])
    panels[0].set_title(plain(f"{name}: residual, {unit}"))


def _draw_spectrum(axes, trace: RunTrace, lines, c: int, step: float) -> None:
    samples, rate = len(trace.time_s), 1.0 / step
    frequency = frequencies_of(samples, rate)[1:]
    width = max(1, round(2.0 * _SMOOTHING_HZ * samples * step))
    for residual, color in lines:
        power = to_frequency(residual)[1:] ** 2
        density = np.sqrt(2.0 * _smooth(power, width) / rate)
        axes.loglog(frequency, density, color=color, lw=0.9)
    if trace.floor_density is not None:
        edges, floor = trace.floor_density
        level = np.sqrt(2.0 * np.asarray(floor)[:, c] / rate)
        shown = np.maximum(edges, frequency[0])
        axes.stairs(level, shown, baseline=None, color=FLOOR, lw=1.2, ls="--")
    axes.set_xlim(frequency[0], frequency[-1])
    axes.set_xlabel("frequency, Hz")
    axes.set_title("spectrum of the residual, unit/√Hz")
    axes.grid()


def _smooth(values: np.ndarray, width: int) -> np.ndarray:
    """Moving average that keeps the length."""
    if width < 2 or width >= len(values):
        return values
    kernel = np.ones(width)
    count = np.convolve(np.ones(len(values)), kernel, mode="same")
    return np.convolve(values, kernel, mode="same") / count

"""The residual of the force against motion, and its spectrum."""

from __future__ import annotations

import numpy as np

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
from brace_drake.report.words import channel_text

_MOST_POINTS = 4000
# Noise of single samples would hide a loop, s.
_PLANE_S = 0.2
# Least bins of the spectrum in one point of its curve.
_SMOOTHING_HZ = 0.15


def draw_plane(trace: RunTrace) -> str | None:
    """Residual against depth and rate, and spectrum, as a data URI.

    None where the run brings neither motion nor floor, or is not evenly
    sampled and finite.
    """
    c = trace.main_channel()
    if c is None or len(trace.time_s) < 32:
        return None
    before = trace.measured[:, c] - trace.before[:, c]
    after = None
    if trace.after is not None:
        after = trace.measured[:, c] - trace.after[:, c]
    lines = [(before, BEFORE)] + [(after, AFTER)] * (after is not None)
    if not all(np.isfinite(v).all() for v, _ in lines):
        return None
    step = float(np.median(np.diff(trace.time_s)))
    if not step > 0.0:
        return None
    has_motion = trace.position is not None
    with figure_style():
        figure = make_figure(WIDTH, 2.5)
        panels = figure.subplots(1, 3 if has_motion else 1, squeeze=False)[0]
        if has_motion:
            _draw_planes(panels, trace, lines, c, step)
        _draw_spectrum(panels[-1], trace, lines, c, step)
        return to_data_uri(figure)


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
                rasterized=True,
            )
        axes.set_xlabel(plain(label))
        axes.grid()
    name = channel_text(trace.channels[c])
    panels[0].set_title(plain(f"{name}: residual, {unit}"))


def _draw_spectrum(axes, trace: RunTrace, lines, c: int, step: float) -> None:
    samples, rate = len(trace.time_s), 1.0 / step
    frequency = np.fft.rfftfreq(samples, step)[1:]
    width = max(1, round(_SMOOTHING_HZ * samples * step))
    for residual, color in lines:
        power = np.abs(np.fft.rfft(residual))[1:] ** 2 / samples
        density = np.sqrt(2.0 * _smooth(power, width) / rate)
        axes.loglog(frequency, density, color=color, lw=0.9, rasterized=True)
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

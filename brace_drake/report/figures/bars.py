"""Bars against the noise floor, and the correlation of the subject's fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from brace_drake.report.canvas import (
    ACQUITTED,
    AFTER,
    BEFORE,
    FLOOR,
    MEASURED,
    WIDTH,
    Encode,
    figure_style,
    make_figure,
    plain,
    shorten,
    to_data_uri,
)
from brace_drake.report.words import NOTHING, fixed, times, to_number

# Every bar starts at the floor: its length is the logarithm of the gap.
_BASE = 1.0
_TICKS = np.array([k * 10.0**e for e in range(-3, 7) for k in (1.0, 2.0, 5.0)])


def draw_blocks(blocks: Sequence[dict], encode: Encode | None = None) -> Any:
    """Normalised RMS of each block against the floor, as a data URI."""
    values = [to_number(b["normalised_rms"]) for b in blocks]
    limits = [to_number(b["threshold"]) for b in blocks]
    if not any(_shown(v) for v in values):
        return None
    with figure_style():
        figure = make_figure(WIDTH, 0.75 + 0.34 * len(blocks))
        axes = figure.subplots()
        for i, (block, value, limit) in enumerate(
            zip(blocks, values, limits, strict=True)
        ):
            acquitted = block["acquitted"]
            color = ACQUITTED if acquitted else BEFORE
            _draw_bar(axes, i, value, 0.56, color)
            note = times(value)
            if acquitted and note != NOTHING:
                note += "  within its threshold"
            # Behind the bar and the threshold, whichever reaches further.
            _draw_note(axes, i, max(_placed(value), _placed(limit)), note)
            if _shown(limit):
                axes.plot(
                    [_placed(limit)] * 2,
                    [i - 0.4, i + 0.4],
                    color=MEASURED,
                    lw=1,
                    zorder=4,
                )
        names = [shorten(b["block"]) for b in blocks]
        _finish_bars(axes, names, [*values, *limits], room=1.35)
        axes.set_xlabel("normalised RMS of the block on its own, floor = 1")
        return (encode or to_data_uri)(figure)


def draw_pairs(
    labels: Sequence[str],
    rows: Sequence[dict],
    width: float,
    encode: Encode | None = None,
) -> Any:
    """Before and after of each row, two bars against the floor."""
    before = [to_number(row["before"]) for row in rows]
    after = [to_number(row["after"]) for row in rows]
    if not any(_shown(v) for v in [*before, *after]):
        return None
    with figure_style():
        figure = make_figure(width, 0.95 + 0.36 * len(labels))
        axes = figure.subplots()
        paired = any(_shown(v) for v in after)
        for i, (old, new) in enumerate(zip(before, after, strict=True)):
            shift = 0.18 if paired else 0.0
            _draw_bar(axes, i - shift, old, 0.3 if paired else 0.5, BEFORE)
            _draw_note(axes, i - shift, old, times(old))
            if paired:
                _draw_bar(axes, i + shift, new, 0.3, AFTER)
                _draw_note(axes, i + shift, new, times(new))
        _finish_bars(
            axes, [shorten(n) for n in labels], [*before, *after], room=1.15
        )
        axes.set_xlabel("RMS of the residual over the floor")
        if paired:
            _draw_legend(figure)
        return (encode or to_data_uri)(figure)


def draw_correlation(
    names: Sequence[str],
    matrix: Sequence[Sequence[float]],
    encode: Encode | None = None,
) -> Any:
    """Correlation of the fitted parameters; None of a single one."""
    n = len(names)
    if n < 2:
        return None
    values = np.array([[to_number(v) for v in row] for row in matrix])
    with figure_style():
        figure = make_figure(1.9 + 0.42 * n, 1.5 + 0.36 * n)
        axes = figure.subplots()
        image = axes.imshow(
            np.ma.masked_invalid(values), cmap="RdBu_r", vmin=-1, vmax=1
        )
        labels = [shorten(name, 22) for name in names]
        axes.set_yticks(range(n), labels)
        axes.set_xticks(
            range(n), labels, rotation=40, ha="right", rotation_mode="anchor"
        )
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
        for i, j in np.ndindex(n, n) if n <= 12 else ():
            text = fixed(float(values[i, j]), 2)
            color = "white" if abs(values[i, j]) > 0.6 else MEASURED
            axes.text(
                j, i, text, ha="center", va="center", fontsize=7, color=color
            )
        bar = figure.colorbar(image, ax=axes, shrink=0.8, ticks=[-1, 0, 1])
        bar.outline.set_visible(False)
        bar.ax.tick_params(length=0)
        return (encode or to_data_uri)(figure)


def _shown(value: float) -> bool:
    return math.isfinite(value) and value > 0.0


def _placed(value: float) -> float:
    # Beyond these the axis, not the number, is what matters.
    return min(max(value, 1e-3), 1e6) if _shown(value) else _BASE


def _draw_bar(axes, y: float, value: float, height: float, color: str) -> None:
    if not _shown(value):
        return
    end = _placed(value)
    # The edge shows a bar that ends at the floor, above the floor's line.
    axes.barh(
        *(y, end - _BASE, height, _BASE), color=color, ec=color, lw=1, zorder=3
    )


def _draw_note(axes, y: float, value: float, text: str) -> None:
    axes.annotate(
        plain(text),
        (max(_placed(value), _BASE), y),
        xytext=(6, 0),
        textcoords="offset points",
        va="center",
        fontsize=8,
        color=MEASURED,
    )


def _draw_legend(figure) -> None:
    from matplotlib.patches import Patch

    figure.legend(
        handles=[
            Patch(color=BEFORE, label="before: fitted nominal twin"),
            Patch(color=AFTER, label="after: with the effect"),
        ],
        loc="outside upper left",
        ncols=2,
        handlelength=1.0,
        handleheight=0.7,
        borderaxespad=0.0,
    )


def _finish_bars(axes, names, values, room: float) -> None:
    shown = [_placed(v) for v in values if _shown(v)]
    low, high = min([*shown, 0.8]), max([*shown, 2.0])
    axes.set_xscale("log")
    # Room at the right for the numbers behind the bars.
    axes.set_xlim(low / 1.1, high * (high / low) ** 0.08 * room)
    left, right = axes.get_xlim()
    inside = _TICKS[(_TICKS >= left) & (_TICKS <= right)]
    if len(inside) > 9:
        inside = inside[np.isclose(np.log10(inside) % 1.0, 0.0)]
    axes.set_xticks(inside, [f"{v:g}" for v in inside])
    axes.set_xticks([], minor=True)
    axes.axvline(_BASE, color=FLOOR, lw=1.2, ls=(0, (4, 2)))
    axes.grid(axis="x")
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_ylim(len(names) - 0.4, -0.6)

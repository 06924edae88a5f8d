"""The gap's budget as pictures: shares of blocks, and the cube."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import wrap

import numpy as np

from brace_drake.report.access import numbers, text
from brace_drake.report.canvas import (
    ACQUITTED,
    BEFORE,
    MEASURED,
    WIDTH,
    figure_style,
    make_figure,
    plain,
    shorten,
    to_data_uri,
)
from brace_drake.report.tables import band_text
from brace_drake.report.words import channel_text, percent

# Channels and panels beyond these would not be read.
_MOST_CHANNELS, _MOST_PHASES = 14, 6
# Characters that the titles of all panels have room for.
_TITLE = 84


def draw_attribution(rows: Sequence[dict]) -> str | None:
    """Share of each block with its 95 % interval, as a data URI."""
    shares = np.array(numbers(list(rows), "share"))
    if not len(shares) or not np.isfinite(shares).any():
        return None
    low = np.array(numbers(list(rows), "lower95"))
    high = np.array(numbers(list(rows), "upper95"))
    with figure_style():
        figure = make_figure(WIDTH, 0.7 + 0.34 * len(rows))
        axes = figure.subplots()
        for i, share in enumerate(np.clip(shares, 0.0, 1.0)):
            if not math.isfinite(share):
                continue
            known = i < len(rows) - 1 or bool(text(rows[i], "block") in _BLOCKS)
            axes.barh(i, share, 0.56, color=BEFORE if known else ACQUITTED)
            ends = np.clip([low[i], high[i]], 0.0, 1.0)
            if np.isfinite(ends).all():
                axes.plot(ends, [i, i], color=MEASURED, lw=1.4)
                axes.plot(ends, [i, i], "|", color=MEASURED, ms=9)
            at = np.nanmax([share, *ends])
            axes.annotate(
                plain(percent(share)),
                (at, i),
                xytext=(7, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
            )
        axes.set_yticks(range(len(rows)), [_label(row) for row in rows])
        axes.set_xlim(0.0, 1.09)
        ticks = np.linspace(0.0, 1.0, 5)
        axes.set_xticks(ticks, [f"{100 * t:.0f} %" for t in ticks])
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
        axes.grid(axis="x")
        axes.set_xlabel("share of the closed-loop gap")
        return to_data_uri(figure)


_BLOCKS = ("actuation", "mechanism", "contact", "torso", "sensing")


def _label(row: dict) -> str:
    others = row.get("or")
    names = [text(row, "block"), *(others if isinstance(others, list) else [])]
    return shorten(" or ".join(str(n) for n in names))


def draw_cube(rows: Sequence[dict]) -> str | None:
    """Shares by channel and band, one panel for each phase, as a data URI."""
    cells = [r for r in rows if _share(r) > 0.0]
    if not cells:
        return None
    phases = _largest(cells, lambda r: text(r, "phase"), _MOST_PHASES)
    channels = _largest(cells, lambda r: text(r, "channel"), _MOST_CHANNELS)
    starts = np.array(numbers(cells, "from_Hz"))
    bands = {band_text(cells[i]): 0 for i in np.argsort(starts, kind="stable")}
    for i, name in enumerate(bands):
        bands[name] = i
    grids = np.zeros((len(phases), len(channels), len(bands)))
    for r in cells:
        phase, channel = text(r, "phase"), text(r, "channel")
        if phase in phases and channel in channels:
            at = phases.index(phase), channels.index(channel)
            grids[(*at, bands[band_text(r)])] += _share(r)
    with figure_style():
        height = 1.45 + 0.235 * len(channels)
        figure = make_figure(WIDTH, height)
        panels = figure.subplots(1, len(phases), sharey=True, squeeze=False)[0]
        top = grids.max()
        for axes, grid, phase in zip(panels, grids, phases, strict=True):
            axes.imshow(grid, cmap="Oranges", vmin=0, vmax=top, aspect="auto")
            total = percent(float(grid.sum()))
            words = wrap(phase, _TITLE // len(phases)) or ["—"]
            axes.set_title("\n".join(map(plain, [*words, total])))
            _write_shares(axes, grid, top)
            names = [b.removesuffix(" Hz").replace(" to ", "–") for b in bands]
            axes.set_xticks(range(len(bands)), names, rotation=35, fontsize=7.5)
            axes.tick_params(length=0)
            axes.spines[:].set_visible(False)
        panels[0].set_yticks(
            range(len(channels)),
            [shorten(channel_text(c)) for c in channels],
        )
        figure.supxlabel("frequency, Hz", fontsize=8.5, color="#46525f")
        return to_data_uri(figure)


def _share(row: dict) -> float:
    value = numbers([row], "share")[0]
    return min(value, 1.0) if math.isfinite(value) else 0.0


def _write_shares(axes, grid: np.ndarray, top: float) -> None:
    for (i, j), share in np.ndenumerate(grid):
        if share < 0.005:
            continue
        color = "white" if share > 0.6 * top else MEASURED
        note = f"{100 * share:.0f}"
        axes.text(j, i, note, ha="center", va="center", fontsize=7, color=color)


def _largest(cells: list[dict], key, most: int) -> list[str]:
    """Names with the largest shares first."""
    total: dict[str, float] = {}
    for r in cells:
        total[key(r)] = total.get(key(r), 0.0) + _share(r)
    return sorted(total, key=lambda name: -total[name])[:most]

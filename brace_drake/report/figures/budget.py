"""Where the residual power lies, as pictures."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import numpy as np

from brace_drake.isolation.shapley import UNEXPLAINED
from brace_drake.report.canvas import (
    ACQUITTED,
    BEFORE,
    MEASURED,
    WIDTH,
    Encode,
    figure_style,
    make_figure,
    plain,
    shorten,
    to_data_uri,
)
from brace_drake.report.words import (
    band_text,
    channel_text,
    percent,
    to_number,
)

# Channels and panels beyond these would not be read.
_MOST_CHANNELS, _MOST_PHASES = 14, 6
# Characters that the titles of all panels have room for.
_TITLE = 84


def draw_attribution(rows: Sequence[dict], encode: Encode | None = None) -> Any:
    """Power of each block with its 95 % interval, as a data URI."""
    if not rows:
        return None
    shares, low, high = (
        np.array([to_number(row[key]) for row in rows])
        for key in ("share", "lower95", "upper95")
    )
    with figure_style():
        figure = make_figure(WIDTH, 0.7 + 0.34 * len(rows))
        axes = figure.subplots()
        for i, share in enumerate(np.clip(shares, 0.0, 1.0)):
            known = rows[i]["block"] != UNEXPLAINED
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
        axes.set_xlabel("residual power")
        return (encode or to_data_uri)(figure)


def _label(row: dict) -> str:
    return shorten(" or ".join([row["block"], *row["or"]]))


def draw_power(rows: Sequence[dict], encode: Encode | None = None) -> Any:
    """Power by channel and band, one panel for each phase, as a data URI."""
    cells = [r for r in rows if r["share"] > 0.0]
    if not cells:
        return None
    phases = _largest(cells, "phase", _MOST_PHASES)
    channels = _largest(cells, "channel", _MOST_CHANNELS)
    rising = sorted(cells, key=lambda r: r["from_Hz"])
    bands = list(dict.fromkeys(map(band_text, rising)))
    grids = np.zeros((len(phases), len(channels), len(bands)))
    for r in cells:
        if r["phase"] in phases and r["channel"] in channels:
            at = phases.index(r["phase"]), channels.index(r["channel"])
            grids[(*at, bands.index(band_text(r)))] += r["share"]
    with figure_style():
        height = 1.45 + 0.235 * len(channels)
        figure = make_figure(WIDTH, height)
        panels = figure.subplots(1, len(phases), sharey=True, squeeze=False)[0]
        top = grids.max()
        for axes, grid, phase in zip(panels, grids, phases, strict=True):
            axes.imshow(grid, cmap="Oranges", vmin=0, vmax=top, aspect="auto")
            total = percent(float(grid.sum()))
            words = wrap(phase, _TITLE // len(phases))
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
        return (encode or to_data_uri)(figure)


def _write_shares(axes, grid: np.ndarray, top: float) -> None:
    for (i, j), share in np.ndenumerate(grid):
        if share < 0.005:
            continue
        color = "white" if share > 0.6 * top else MEASURED
        note = f"{100 * share:.0f}"
        axes.text(j, i, note, ha="center", va="center", fontsize=7, color=color)


def _largest(cells: list[dict], key: str, most: int) -> list[str]:
    """Names with the largest shares first."""
    total: dict[str, float] = {}
    for r in cells:
        total[r[key]] = total.get(r[key], 0.0) + r["share"]
    return sorted(total, key=lambda name: -total[name])[:most]

"""A law over the variable that it depends on, beside what was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from brace_drake.report.canvas import (
    FLOOR,
    LAW,
    MEASURED,
    WIDTH,
    Encode,
    figure_style,
    make_figure,
    plain,
    to_data_uri,
)

if TYPE_CHECKING:
    from brace_drake.report.law_curve import LawCurve

# Points of a line that are drawn.
_MOST_POINTS = 1500
_PALE = "#b3bcc6"


def draw_law(law: LawCurve, encode: Encode | None = None) -> Any:
    """The law along the recorded motions, as a data URI.

    Where it is a function of the variable alone its runs lie on one curve.
    None where no run has a value.
    """
    lines = [(x, y) for _, _, x, y in law.runs if np.isfinite(y).any()]
    if not lines:
        return None
    with figure_style():
        figure = make_figure(WIDTH, 2.9)
        axes = figure.subplots()
        axes.axhline(0.0, color=FLOOR, lw=0.6)
        if law.found is not None:
            _draw_found(axes, *law.found)
        for i, (x, y) in enumerate(lines):
            every = max(1, len(x) // _MOST_POINTS)
            label = "the law along the runs" if i == 0 else None
            axes.plot(
                x[::every],
                y[::every],
                color=LAW,
                lw=1.4,
                label=label,
                rasterized=True,
                zorder=3,
            )
        axes.set_xlabel(plain(law.variable))
        axes.set_title(plain(law.quantity))
        axes.grid()
        figure.legend(loc="outside upper right", ncols=2, borderaxespad=0.0)
        return (encode or to_data_uri)(figure)


def _draw_found(axes, x: np.ndarray, found: np.ndarray) -> None:
    """Bins with their spread where x is a few bins, else a line."""
    middle, low, high = found.T
    if np.isfinite(low).any():
        spread = np.abs(np.stack([middle - low, high - middle]))
        axes.errorbar(
            x,
            middle,
            yerr=spread,
            fmt="o",
            ms=4,
            color=MEASURED,
            ecolor=_PALE,
            elinewidth=1.4,
            label="force that the twin lacks, from the recording",
            zorder=2,
        )
        return
    axes.plot(
        x,
        middle,
        color=_PALE,
        lw=2.2,
        label="force that the twin lacks, from the recording",
        rasterized=True,
        zorder=2,
    )

"""Small multiples: one number over time, with error bars and its alarm."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from brace_drake.report.canvas import (
    ACQUITTED,
    AFTER,
    BEFORE,
    FLOOR,
    MEASURED,
    figure_style,
    make_figure,
    plain,
    to_data_uri,
)
from brace_drake.report.words import scale_of
from brace_drake.trend.alarms import DRIFT
from brace_drake.trend.sentences import number_name

# Inches; two stand side by side on the page.
_WIDTH, _HEIGHT = 4.6, 2.35
_MOST_TICKS = 5


def draw_series(row: dict, sessions: Sequence[dict]) -> str:
    """A number of a trend's document over its sessions, as a data URI."""
    place = place_sessions(sessions)
    points = [p for p in row["points"] if p["value"] is not None]
    factor, unit = scale_of(row["unit"], [p["value"] for p in points])
    if row["of"] == "twin":
        unit = "noise floors"
    with figure_style():
        figure = make_figure(_WIDTH, _HEIGHT)
        axes = figure.subplots()
        _draw_mean(axes, row, factor)
        _draw_points(axes, points, place, factor)
        _draw_alarm(axes, row, points, place, factor)
        name = number_name(row)
        name = f"{name[:1].upper()}{name[1:]}, {unit}".removesuffix(", ")
        axes.set_title(plain(name))
        finish_time(axes, sessions)
        axes.grid(axis="y")
        return to_data_uri(figure)


def draw_closed(sessions: Sequence[dict]) -> str | None:
    """Share of the gap that each session's effects close; None without."""
    shown = [(i, s) for i, s in enumerate(sessions) if s["closed"] is not None]
    if not shown:
        return None
    place = place_sessions(sessions)
    points = []
    for i, session in shown:
        low, high = session["closed_interval"] or (None, None)
        point = {"session": i, "value": session["closed"], "left_out": ""}
        points.append(point | {"lower95": low, "upper95": high})
    with figure_style():
        figure = make_figure(_WIDTH, _HEIGHT)
        axes = figure.subplots()
        _draw_points(axes, points, place, 100.0)
        axes.set_title(plain("Share of the gap closed, %"))
        finish_time(axes, sessions)
        axes.grid(axis="y")
        return to_data_uri(figure)


def place_sessions(sessions: Sequence[dict]) -> np.ndarray:
    """Where sessions lie on the axis of time: days of the calendar, or their
    numbers (n,).
    """
    dates = [s["date"] for s in sessions]
    if None in dates:
        return np.arange(1.0, len(sessions) + 1.0)
    from matplotlib.dates import date2num

    return np.array([date2num(datetime.fromisoformat(d)) for d in dates])


def finish_time(axes, sessions: Sequence[dict]) -> None:
    """Ticks of the axis of time, with a margin beside the first and last."""
    from matplotlib import dates, ticker

    place = place_sessions(sessions)
    span = float(np.ptp(place)) or 1.0
    axes.set_xlim(place[0] - 0.06 * span, place[-1] + 0.06 * span)
    if sessions[0]["date"] is None:
        locator = ticker.MaxNLocator(_MOST_TICKS, integer=True)
        axes.xaxis.set_major_locator(locator)
        axes.set_xlabel("session")
        return
    locator = dates.AutoDateLocator(minticks=2, maxticks=_MOST_TICKS)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator))


def _draw_mean(axes, row: dict, factor: float) -> None:
    """The weighted mean with its interval, scatter included where known."""
    tests = row["tests"]
    if tests is None:
        return
    own = tests["mean_with_scatter"] or tests["mean"]
    low, high = own["lower95"], own["upper95"]
    # Of two sessions the interval would hide all else.
    if tests["sessions"] > 2:
        axes.axhspan(low * factor, high * factor, color=FLOOR, alpha=0.13, lw=0)
    axes.axhline(own["value"] * factor, color=FLOOR, lw=0.9, ls=(0, (4, 2)))


def _draw_points(axes, points, place: np.ndarray, factor: float) -> None:
    for used in (True, False):
        shown = [p for p in points if (not p["left_out"]) is used]
        if not shown:
            continue
        x = [place[p["session"]] for p in shown]
        y = np.array([p["value"] for p in shown]) * factor
        ends = np.array(
            [[p["lower95"], p["upper95"]] for p in shown], dtype=float
        )
        bars = np.abs(ends.T * factor - y)
        axes.errorbar(
            x,
            y,
            yerr=np.where(np.isfinite(bars), bars, 0.0),
            fmt="o",
            ms=4.5,
            lw=1.3,
            capsize=2.5,
            color=AFTER if used else ACQUITTED,
            mfc=AFTER if used else "white",
            zorder=3,
        )


def _draw_alarm(axes, row, points, place, factor: float) -> None:
    """A line of a drift, and a mark at the session of the alarm."""
    if not row["alarm"]:
        return
    tests = row["tests"]
    if row["alarm"] == DRIFT:
        used = [p["session"] for p in points if not p["left_out"]]
        slope = tests["trend"]["with_scatter"]["value"] * factor
        x, middle = place[used], tests["mean"]["value"] * factor
        values = np.array([p["value"] for p in points if not p["left_out"]])
        weight = np.array(
            [p["standard_error"] for p in points if not p["left_out"]]
        )
        wide = 1.0 / (weight**2 + tests["scatter"]["value"] ** 2)
        middle = factor * float(wide @ values / wide.sum())
        centre = float(wide @ x / wide.sum())
        axes.plot(x, middle + slope * (x - centre), color=BEFORE, lw=1.2)
    axes.axvline(place[row["at"]], color=BEFORE, lw=0.8, ls=(0, (1, 2)))
    axes.annotate(
        plain(f"▲ {row['alarm']}"),
        (place[row["at"]], 0.0),
        xycoords=("data", "axes fraction"),
        xytext=(-4 if row["at"] else 4, 4),
        textcoords="offset points",
        ha="right" if row["at"] else "left",
        fontsize=8.5,
        color=BEFORE,
        bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.0},
        zorder=4,
    )
    axes.tick_params(axis="both", color=MEASURED)

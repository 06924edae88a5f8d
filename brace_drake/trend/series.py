"""Series: one number of a trend over its sessions, with all its tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import NormalDist

import numpy as np

from brace_drake.trend.form import LEAST_ERROR
from brace_drake.trend.grouping import Timeline
from brace_drake.trend.sessions import Estimate
from brace_drake.trend.statistics import (
    Fit,
    Step,
    constancy,
    find_steps,
    fit_line,
    fit_mean,
    scatter_interval,
)

GAP = "gap"
_WIDTH = 2.0 * NormalDist().inv_cdf(0.975)


@dataclass(frozen=True)
class Point:
    """A number in one session.

    Attributes:
        session: Its index in the timeline.
        time: As the timeline has it.
        value, error: None where there is none.
        lower95, upper95: Its interval.
        left_out: Why no test uses it; empty where one does.
    """

    session: int
    time: float
    value: float | None
    error: float | None
    lower95: float | None
    upper95: float | None
    left_out: str = ""


@dataclass(frozen=True)
class Tests:
    """What is tested of a series; None of fewer than two usable points.

    Attributes:
        mean: Weighted mean.
        constancy_p, birge: Of equal values, see `statistics.constancy`.
        scatter95: Interval of the scatter between sessions.
        line: Trend over time; None at one time alone.
        step: The most significant by the stated intervals, and beside a
            scatter.
    """

    mean: Fit
    constancy_p: float
    birge: float
    scatter95: tuple[float, float]
    line: Fit | None
    step: tuple[Step, Step]


@dataclass(frozen=True)
class Series:
    """One number over the sessions.

    Attributes:
        name, unit, of: See `Estimate`; the gap is of "twin".
        points: One for each session that has the number.
        tests: None where fewer than two can be used.
        note: Why it is not tested; empty where it is.
    """

    name: str
    unit: str
    of: str
    points: tuple[Point, ...]
    tests: Tests | None = None
    note: str = ""
    used: tuple[Point, ...] = field(default=())


def make_series(name: str, unit: str, of: str, points, note="") -> Series:
    """A series with its tests."""
    used = () if note else tuple(p for p in points if not p.left_out)
    tests = None
    if len(used) >= 2:
        tests = run_tests(
            *(_array(used, k) for k in ("time", "value", "error"))
        )
    elif not note:
        note = "fewer than two sessions estimate it with an interval"
    return Series(name, unit, of, tuple(points), tests, note, used)


def _array(points: Sequence[Point], key: str) -> np.ndarray:
    return np.array([getattr(p, key) for p in points], dtype=float)


def run_tests(t: np.ndarray, x: np.ndarray, s: np.ndarray) -> Tests:
    """All tests of values x with errors s at times t, in order (n,)."""
    mean = fit_mean(x, s)
    p, birge = constancy(mean)
    steps = find_steps(x, s)
    assert steps is not None
    ends = scatter_interval(x, s)
    return Tests(mean, p, birge, ends, fit_line(t, x, s), steps)


def parameter_series(
    timeline: Timeline, repeatability: float = 0.0
) -> list[Series]:
    """Series of the subject's parameters, then of those of named effects.

    Args:
        timeline: The sessions.
        repeatability: Standard deviation, as a share of the value, by which an
            unchanged parameter differs between sessions as far as that is
            known; it is added to every error in quadrature.
    """
    found: dict[tuple[str, str, str], list[Point]] = {}
    for i, session in enumerate(timeline.sessions):
        for estimate in session.estimates():
            key = estimate.of, estimate.name, estimate.unit
            point = _point(i, timeline.times[i], estimate, repeatability)
            found.setdefault(key, []).append(point)
    # Those of the subject come first, in the order of the diagnosis.
    keys = sorted(found, key=lambda k: k[0] != "subject")
    return [make_series(n, u, of, found[of, n, u]) for of, n, u in keys]


def _point(i: int, time: float, e: Estimate, share: float) -> Point:
    error, ends = e.error, (e.lower95, e.upper95)
    if error is not None and share > 0.0:
        error = float(np.hypot(error, share * e.value))
        half = 0.5 * _WIDTH * error
        ends = e.value - half, e.value + half
    return Point(i, time, e.value, error, *ends, e.why_left_out)


def gap_series(timeline: Timeline) -> Series:
    """The gap before any repair, noise floors, on the validation runs."""
    points, motions = [], set()
    for i, session in enumerate(timeline.sessions):
        shrink = session.shrink
        value, ends = shrink.get("before"), shrink.get("before_interval")
        if value is None:
            continue
        motions.add(tuple(sorted(shrink["runs"])))
        low, high = ends or (None, None)
        width = high - low if ends else 0.0
        error, why = None, "without an interval"
        if width / _WIDTH >= LEAST_ERROR:
            error, why = width / _WIDTH, ""
        points.append(Point(i, timeline.times[i], value, error, low, high, why))
    note = ""
    if len(motions) > 1:
        note = (
            "the sessions have different validation runs, and a gap depends on"
            " the motion"
        )
    return make_series(GAP, "", "twin", points, note)

"""Alarms: one false-alarm level shared out over all tests of a page.

Half of the level goes to numbers, by Holm's correction over all their tests;
half to effects, by Holm's correction over effects. A number raises an alarm
where it moves by more than its stated intervals. Tests beside a scatter between
sessions, at the same level, tell the kind of alarm: a drift or a step that
stands out of the scatter is called so, all else is called scatter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.trend.grouping import Timeline
from brace_drake.trend.presence import switch_probability
from brace_drake.trend.series import GAP, Series
from brace_drake.trend.statistics import LEAST_FOR_SCATTER, holm

LEVEL = 0.01  # probability of any alarm on a page where nothing changes
DRIFT, STEP, SCATTER, MOVED = "drift", "step", "scatter", "moved"
GROWS, APPEARS, DISAPPEARS = "gap grows", "appears", "disappears"


@dataclass(frozen=True)
class Judged:
    """A series with what is decided of it.

    Attributes:
        series: The number.
        p: Corrected probabilities by test: constancy, trend, step; of the gap
            one-sided ones of growth.
        p_scattered: Corrected ones of trend and step beside a scatter, of
            numbers that move.
        alarm: DRIFT, STEP, SCATTER, MOVED or GROWS; empty without.
        at: Session at which a step or a move comes first to light.
    """

    series: Series
    p: dict[str, float]
    p_scattered: dict[str, float]
    alarm: str
    at: int | None


@dataclass(frozen=True)
class EffectHistory:
    """One effect over the sessions.

    Attributes:
        name, title: Of the effect.
        named: Whether each session names it; None where it leaves that open.
        probability: Its own where it is named, else None.
        p: Corrected probability of so clear a switch where nothing changes.
        alarm: APPEARS or DISAPPEARS; empty without.
        at: Session from which on it is there, or gone; None without a switch.
    """

    name: str
    title: str
    named: tuple[bool | None, ...]
    probability: tuple[float | None, ...]
    p: float
    alarm: str
    at: int | None


def judge_series(
    series: Sequence[Series], level: float = LEVEL / 2.0
) -> list[Judged]:
    """Tests all numbers of a page at one level, Holm over tests and numbers."""
    stated = _corrected([_stated(s) for s in series])
    moved = [min(p.values(), default=1.0) <= level for p in stated]
    # How far values are from their mean says nothing of where they lie in time:
    # the second tests are for those alone that the first have found.
    beside = _corrected(
        [_beside(s) if m else {} for s, m in zip(series, moved, strict=True)]
    )
    return [
        _decide(s, p, q, level)
        for s, p, q in zip(series, stated, beside, strict=True)
    ]


def _corrected(families: list[dict[str, float]]) -> list[dict[str, float]]:
    flat = [(i, test) for i, own in enumerate(families) for test in own]
    found = holm([families[i][test] for i, test in flat])
    out: list[dict[str, float]] = [{} for _ in families]
    for (i, test), p in zip(flat, found, strict=True):
        out[i][test] = p
    return out


def _growth(p: float, value: float) -> float:
    """One-sided from two-sided."""
    return p / 2.0 if value > 0.0 else 1.0 - p / 2.0


def _stated(series: Series) -> dict[str, float]:
    """Uncorrected probabilities by the stated intervals."""
    tests = series.tests
    if tests is None:
        return {}
    step = tests.step[0]
    if series.name == GAP:
        # That it shrinks is no alarm, nor that it is now this and now that.
        change = step.fit.stated
        if len(series.used) == 2:
            return {"step": _growth(change.p, change.value)}
        found = {"step": step.p if change.value > 0.0 else 1.0}
        if tests.line is not None:
            line = tests.line.stated
            found["trend"] = _growth(line.p, line.value)
        return found
    # Of two values all tests are one.
    if len(series.used) == 2:
        return {"constancy": tests.constancy_p}
    found = {"constancy": tests.constancy_p, "step": step.p}
    if tests.line is not None:
        found["trend"] = tests.line.stated.p
    return found


def _beside(series: Series) -> dict[str, float]:
    """Uncorrected probabilities of trend and step beside a scatter."""
    tests = series.tests
    if tests is None or len(series.used) < LEAST_FOR_SCATTER:
        return {}
    found = {"step": tests.step[1].p_scattered}
    if tests.line is not None and tests.line.scattered is not None:
        found["trend"] = tests.line.scattered.p
    return found


def _decide(series: Series, p, beside, level: float) -> Judged:
    tests = series.tests
    if tests is None or min(p.values()) > level:
        return Judged(series, p, beside, "", None)
    at = series.used[tests.step[0].after].session
    if series.name == GAP:
        return Judged(series, p, beside, GROWS, at)
    if len(series.used) < LEAST_FOR_SCATTER:
        return Judged(series, p, beside, MOVED, at)
    ranked = sorted(beside, key=lambda test: beside[test])
    best = ranked[0] if ranked and beside[ranked[0]] <= level else ""
    if best == "trend":
        return Judged(series, p, beside, DRIFT, series.used[-1].session)
    if best == "step":
        at = series.used[tests.step[1].after].session
        return Judged(series, p, beside, STEP, at)
    return Judged(series, p, beside, SCATTER, _farthest(series))


def _farthest(series: Series) -> int:
    """The session that is farthest from the mean, in its own errors."""
    assert series.tests is not None
    mean = series.tests.mean.stated.value
    away = [abs(p.value - mean) / p.error for p in series.used]
    return series.used[int(np.argmax(away))].session


def judge_effects(
    timeline: Timeline, level: float = LEVEL / 2.0
) -> list[EffectHistory]:
    """Tests every effect that a session names for its coming or going."""
    titles = {e.name: e.title for s in timeline.sessions for e in s.effects}
    raw = [_history(timeline, name, title) for name, title in titles.items()]
    corrected = holm([history.p for history in raw])
    return [
        _alarm(history, p, level)
        for history, p in zip(raw, corrected, strict=True)
    ]


def _history(timeline: Timeline, name: str, title: str) -> EffectHistory:
    sessions = timeline.sessions
    named = tuple(s.names(name) for s in sessions)
    told = [i for i, n in enumerate(named) if n is not None]
    wrong = np.array([sessions[i].wrong(name) for i in told])
    p, after = switch_probability(
        np.array([named[i] for i in told], dtype=bool), wrong
    )
    probability = tuple(
        1.0 - s.wrong(name) if n else None
        for s, n in zip(sessions, named, strict=True)
    )
    at = None if after is None else told[after]
    return EffectHistory(name, title, named, probability, p, "", at)


def _alarm(history: EffectHistory, p: float, level: float) -> EffectHistory:
    alarm = ""
    if history.at is not None and p <= level:
        after = [n for n in history.named[history.at :] if n is not None]
        alarm = APPEARS if sum(after) * 2 > len(after) else DISAPPEARS
    return EffectHistory(
        history.name,
        history.title,
        history.named,
        history.probability,
        p,
        alarm,
        history.at,
    )

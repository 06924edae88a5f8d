"""A trend as the document that is written down: format brace-trend/1."""

from __future__ import annotations

import importlib.metadata
import math

from brace_drake.trend.alarms import (
    GROWS,
    LEVEL,
    EffectHistory,
    Judged,
    judge_effects,
    judge_series,
)
from brace_drake.trend.grouping import Timeline
from brace_drake.trend.sentences import (
    effect_sentence,
    series_sentence,
    state_level,
    summary_sentence,
)
from brace_drake.trend.series import (
    Point,
    Series,
    gap_series,
    parameter_series,
)
from brace_drake.trend.sessions import Session
from brace_drake.trend.statistics import Coefficient, detectable

FORMAT = "brace-trend/1"


def MakeTrendDocument(
    timeline: Timeline, level: float = LEVEL, repeatability: float = 0.0
) -> dict:
    """The trend of sessions in plain JSON types.

    Args:
        timeline: Two sessions or more.
        level: Probability of any alarm where nothing changes.
        repeatability: See `parameter_series`.
    """
    series = [*parameter_series(timeline, repeatability), gap_series(timeline)]
    judged = judge_series(series, level / 2.0)
    effects = judge_effects(timeline, level / 2.0)
    tests = sum(len(j.p) for j in judged)
    rows = [
        _series_row(j, timeline, level / 2.0 / max(1, tests)) for j in judged
    ]
    effect_rows = [_effect_row(h, timeline) for h in effects]
    alarms = [_alarm_row(row, timeline) for row in [*rows, *effect_rows]]
    first = timeline.sessions[0]
    found = {
        "format": FORMAT,
        "device": first.device,
        "subject_name": first.subject,
        "time": {"source": timeline.source, "unit": timeline.unit},
        "level": {
            "page": level,
            "numbers": level / 2.0,
            "effects": level / 2.0,
            "tests_of_numbers": tests,
            "repeatability": repeatability,
            "statement": state_level(level, timeline),
        },
        "alarms": [alarm for alarm in alarms if alarm],
        "sessions": [
            _session_row(s, t)
            for s, t in zip(timeline.sessions, timeline.times, strict=True)
        ],
        "parameters": rows[:-1],
        "gap": rows[-1],
        "effects": effect_rows,
        "provenance": {
            "versions": {
                "brace_drake": importlib.metadata.version("brace_drake")
            },
            "data_sha256": [s.data_sha256 for s in timeline.sessions],
        },
    }
    found["sentence"] = summary_sentence(found)
    return found


def _session_row(session: Session, time: float) -> dict:
    shrink = session.shrink
    return {
        "name": session.name,
        "folder": str(session.folder),
        "date": None if session.date is None else session.date.isoformat(),
        "time": time,
        "sentence": session.sentence,
        "gap": session.gap,
        "effects": [e.name for e in session.effects],
        "outside_library": session.outside,
        "recording_fault": session.faulty,
        "probability": session.probability,
        "gap_before": shrink.get("before"),
        "gap_after": shrink.get("after"),
        "closed": shrink.get("closed"),
        "closed_interval": shrink.get("closed_interval"),
    }


def _series_row(judged: Judged, timeline: Timeline, level: float) -> dict:
    series = judged.series
    row = {
        "name": series.name,
        "unit": series.unit,
        "of": series.of,
        "points": [_point_row(p) for p in series.points],
        "note": series.note,
        "alarm": judged.alarm or None,
        "at": judged.at,
        "tests": _tests_row(series, judged, level),
    }
    row["sentence"] = series_sentence(row, timeline.unit)
    return row


def _point_row(p: Point) -> dict:
    return {
        "session": p.session,
        "value": p.value,
        "standard_error": p.error,
        "lower95": p.lower95,
        "upper95": p.upper95,
        "left_out": p.left_out,
    }


def _tests_row(series: Series, judged: Judged, level: float) -> dict | None:
    """All tests of a number; `level` is that of the strictest of the page."""
    tests = series.tests
    if tests is None:
        return None
    n = len(series.used)
    mean = tests.mean
    ends = [None if math.isinf(v) else v for v in tests.scatter95]
    row: dict = {
        "sessions": n,
        "mean": _coefficient(mean.stated),
        "mean_with_scatter": mean.scattered and _coefficient(mean.scattered),
        "constancy": {
            "chi2": mean.chi2,
            "degrees_of_freedom": mean.freedom,
            "p": tests.constancy_p,
            "p_corrected": judged.p.get("constancy"),
            "birge_ratio": tests.birge,
        },
        "scatter": {
            "value": mean.scatter,
            "lower95": ends[0],
            "upper95": ends[1],
        },
        "trend": None,
    }
    line = tests.line
    if line is not None:
        found = line.scattered or line.stated
        span = series.used[-1].time - series.used[0].time
        freedom = line.freedom if line.scattered else math.inf
        row["trend"] = {
            "stated": _coefficient(line.stated),
            "with_scatter": line.scattered and _coefficient(line.scattered),
            "span": span,
            "p_corrected": judged.p.get("trend"),
            "p_corrected_with_scatter": judged.p_scattered.get("trend"),
            # Of one degree of freedom it would be many times the value.
            "detectable_change": _finite(
                abs(span) * detectable(found, freedom, level)
            )
            if line.freedom > 1
            else None,
        }
    stated, beside = tests.step
    row["step"] = {
        "before_session": series.used[stated.after].session,
        "stated": _coefficient(stated.fit.stated),
        "p": stated.p,
        "p_corrected": judged.p.get("step"),
        "before_session_with_scatter": series.used[beside.after].session,
        "with_scatter": beside.fit.scattered
        and _coefficient(beside.fit.scattered),
        "p_corrected_with_scatter": judged.p_scattered.get("step"),
    }
    return row


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _coefficient(c: Coefficient) -> dict:
    return {
        "value": c.value,
        "standard_error": c.error,
        "lower95": _finite(c.lower95),
        "upper95": _finite(c.upper95),
        "p": c.p,
    }


def _effect_row(history: EffectHistory, timeline: Timeline) -> dict:
    row = {
        "name": history.name,
        "title": history.title,
        "named": list(history.named),
        "probability": list(history.probability),
        "p_corrected": history.p,
        "alarm": history.alarm or None,
        "at": history.at,
    }
    row["sentence"] = effect_sentence(row)
    return row


def _alarm_row(row: dict, timeline: Timeline) -> dict | None:
    """An alarm of a number or an effect; None where there is none."""
    if row["alarm"] is None:
        return None
    is_effect = "named" in row
    of = "effect" if is_effect else row["of"]
    session = timeline.sessions[row["at"]]
    return {
        "kind": row["alarm"],
        "of": "gap" if row["alarm"] == GROWS else of,
        "name": row["name"],
        "session": row["at"],
        "session_name": session.name,
        "sentence": row["sentence"],
    }

"""The traces of a page: the one of its first screen, then every run."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from brace_drake.report.figures.traces import draw_plane, draw_trace
from brace_drake.report.traces import VALIDATION, RunTrace, most_telling
from brace_drake.report.viewer import (
    encode_runs,
    viewer_script,
    viewer_style,
)
from brace_drake.report.words import channel_text, fixed, times

# Of more runs only the first have a picture beside the data that are zoomed.
_MOST_PICTURES = 16


def view_runs(traces: Sequence[RunTrace], rows: Sequence[dict]) -> dict:
    """What the templates need of the runs.

    Args:
        traces: Of the runs, in the order of the page.
        rows: Of the document, one for each run of the campaign.
    """
    known = {row["run"]: row for row in rows}
    hero = _view_hero(traces)
    first = hero["run"] if hero else None
    return {
        "hero": hero,
        "shown": [
            _view_run(trace, i, known.get(trace.name, {}), i == first)
            for i, trace in enumerate(traces)
        ],
        "validated": any(t.split == VALIDATION for t in traces),
        "data": Markup(encode_runs(traces)),
        "script": Markup(viewer_script()),
        "style": Markup(viewer_style()),
    }


def _view_hero(traces: Sequence[RunTrace]) -> dict | None:
    """The run and channel that show the gap best."""
    found = most_telling(traces)
    if found is None:
        return None
    i, c = found
    trace = traces[i]
    gaps = dict.fromkeys(("before", "after", "law"), "") | {
        kind: times(float(trace.normalised_rms(twin)[c]))
        for kind, twin in trace.twins()
    }
    return {
        "run": i,
        "channel": trace.ranked_channels().index(c),
        "name": trace.name,
        "split": trace.split,
        "label": channel_text(trace.channels[c]),
        "gaps": gaps,
        "image": draw_trace(trace, c),
    }


def _view_run(trace: RunTrace, i: int, row: dict, is_first: bool) -> dict:
    return {
        "index": i,
        "name": trace.name,
        "split": trace.split,
        "motion": row.get("motion", ""),
        "repeat_of": row.get("repeat_of"),
        "duration": f"{fixed(trace.time_s[-1] - trace.time_s[0], 1)} s",
        "gaps": [
            times(row[key])
            for key in ("before", "after", "with_law")
            if row.get(key) is not None
        ],
        "image": draw_trace(trace) if i < _MOST_PICTURES else None,
        "plane": draw_plane(trace) if is_first else None,
        "is_empty": not trace.ranked_channels(),
    }

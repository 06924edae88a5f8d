"""Blocks of samples that are not there, under times that go on evenly."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.recording.columns import Channel
from brace_drake.recording.jumps import jumps_in
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.statistics import noise_deviation


def jumps_of(way: np.ndarray) -> np.ndarray:
    """Rows after which a way goes on elsewhere (J,), by its own noise, and by
    the step of its readings, half of which each is off by.
    """
    steps = np.abs(np.diff(way))
    least = float(np.min(steps, where=steps > 0.0, initial=np.inf))
    noise = noise_deviation(way)
    return jumps_in(way, max(noise, 0.5 * least) if least < np.inf else noise)


def find_lost(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """A warning where a way that was measured jumps while it moves."""
    found = []
    for name, channel in known.items():
        if not channel.is_way or name not in run.channels:
            continue
        values = lost_of(run, name)
        if values is not None:
            rows = jumps_of(run.channels[name])
            detail = (
                f"{name} jumps {len(rows)} times, first at"
                f" {values['start_s']:.4g} s"
            )
            found.append(
                Finding(
                    CARD,
                    (run.file,),
                    (),
                    values,
                    probability=0.8,
                    detail=detail,
                    severity="warning",
                    row=int(rows[0]) + 2,
                )
            )
    return found


def lost_of(run: Run, name: str) -> dict[str, float] | None:
    """Parameters of what a run has lost where a channel jumps; None where it
    does not.
    """
    rows = jumps_of(run.channels[name])
    if not len(rows):
        return None
    steps, first = np.abs(np.diff(run.channels[name])), int(rows[0])
    usual = max(steps[first - 1], steps[first + 1])
    period = float(np.median(np.diff(run.time_s)))
    return {
        "start_s": float(run.time_s[first] - run.time_s[0]),
        "lost_s": float(steps[first] / usual - 1.0) * period,
        "jumps": float(len(rows)),
    }


def _undo(columns, channels, values):
    """The longest part in which no channel jumps."""
    rows = np.unique(np.concatenate([jumps_of(columns[c]) for c in channels]))
    ends = np.array([0, *(rows + 1), len(columns["time_s"])])
    longest = int(np.argmax(np.diff(ends)))
    begin, end = ends[longest : longest + 2]
    time = columns["time_s"][: end - begin]
    kept = {name: series[begin:end] for name, series in columns.items()}
    return {**kept, "time_s": time}


CARD = RecordingFault(
    name="lost_samples",
    title="lost blocks of samples",
    law="rec(n) = x(n + m) from a sample on",
    signature="the reference jumps by more than its recorded velocity allows",
    remedy="record again, or write the true time_s: gaps of up to five samples"
    " are filled",
    parameters=(
        FaultParameter("start_s", "s", "time of the first jump"),
        FaultParameter("lost_s", "s", "time that is missing there"),
        FaultParameter("jumps", "1", "number of jumps"),
    ),
    undo=_undo,
    is_of_run=True,
)

"""The traces of a diagnosis that its report draws."""

from __future__ import annotations

import numpy as np

from brace_drake.diagnosis import Diagnosis
from brace_drake.identification.gap import RunComparison
from brace_drake.report.traces import RunTrace


def MakeTraces(d: Diagnosis) -> list[RunTrace]:
    """Measured and predicted channels of every run, those held back first."""
    by_law = {c.prepared.run.file: c.after for c in d.law.runs} if d.law else {}
    return [
        _trace(d, c, by_law.get(c.prepared.run.file))
        for c in (*d.validation_runs, *d.fit_runs)
    ]


def _trace(
    d: Diagnosis, c: RunComparison, with_law: np.ndarray | None
) -> RunTrace:
    signals = d.device.motion_signals(c.prepared, d.nominal.subject)
    floor, run = c.prepared.floor, c.prepared.run
    # What tells nothing in a run, as the marker of no torso, is not shown.
    twin = d.device.twin
    shown = twin.recorded(run) & twin.active(run)
    # Where a sample does not count, recording and twin are drawn as one.
    written = twin.written(run)
    beside = written - c.prepared.measured

    def drawn(replay: np.ndarray | None) -> np.ndarray | None:
        return None if replay is None else replay + beside

    return RunTrace(
        run.name,
        run.split,
        run.time_s - run.time_s[0],
        twin.channels,
        np.where(shown, written, np.nan),
        c.before + beside,
        drawn(c.after),
        floor.rms,
        signals.travel,
        signals.travel_name,
        (floor.edges, floor.density),
        drawn(with_law),
    )

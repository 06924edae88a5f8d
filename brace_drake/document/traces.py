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
    shown = d.device.twin.recorded(run) & d.device.twin.active(run)
    return RunTrace(
        run.name,
        run.split,
        run.time_s - run.time_s[0],
        d.device.twin.channels,
        np.where(shown, c.prepared.measured, np.nan),
        c.before,
        c.after,
        floor.rms,
        signals.travel,
        signals.travel_name,
        (floor.edges, floor.density),
        with_law,
    )

"""The traces of a diagnosis that its report draws."""

from __future__ import annotations

import numpy as np

from brace_drake.diagnosis import Diagnosis
from brace_drake.identification.gap import RunComparison
from brace_drake.report.traces import RunTrace


def MakeTraces(d: Diagnosis) -> list[RunTrace]:
    """Measured, nominal and repaired channels of the validation runs."""
    return [make_trace(d, c) for c in d.validation_runs or d.fit_runs]


def make_trace(d: Diagnosis, c: RunComparison) -> RunTrace:
    """Measured, nominal and repaired channels of one run."""
    signals = d.device.motion_signals(c.prepared, d.nominal.subject)
    floor = c.prepared.floor
    recorded = d.device.twin.recorded(c.prepared.run)
    return RunTrace(
        c.prepared.run.name,
        c.prepared.run.split,
        c.prepared.run.time_s - c.prepared.run.time_s[0],
        d.device.twin.channels,
        np.where(recorded, c.prepared.measured, np.nan),
        c.before,
        c.after,
        floor.rms,
        signals.travel,
        signals.travel_name,
        (floor.edges, floor.density),
    )

"""The traces of a diagnosis that its report draws."""

from __future__ import annotations

import numpy as np

from brace_drake.diagnose import Diagnosis
from brace_drake.report.traces import RunTrace


def MakeTraces(d: Diagnosis) -> list[RunTrace]:
    """Measured, nominal and repaired channels of the validation runs."""
    traces = []
    for c in d.validation_runs or d.fit_runs:
        signals = d.device.motion_signals(c.prepared, d.nominal.subject)
        floor = c.prepared.floor
        recorded = d.device.twin.recorded(c.prepared.run)
        traces.append(
            RunTrace(
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
        )
    return traces

"""The traces of a diagnosis that its report draws."""

from __future__ import annotations

import numpy as np

from brace_drake.gap.bench_ladder import ring_poses
from brace_drake.gap.diagnose import Diagnosis
from brace_drake.gap.evaluation import PreparedRun
from brace_drake.report.traces import RunTrace
from brace_drake.twin.bench_twin import BenchTwin

_LENGTHS, _TORSO_Y = slice(6, 12), 16


def MakeTraces(d: Diagnosis) -> list[RunTrace]:
    """Measured, nominal and repaired channels of the validation runs."""
    traces = []
    for c in d.validation_runs or d.fit_runs:
        position, name = _motion(d, c.prepared)
        floor = c.prepared.floor
        traces.append(
            RunTrace(
                c.prepared.run.name,
                c.prepared.run.split,
                c.prepared.run.time_s - c.prepared.run.time_s[0],
                d.device.twin.channels,
                c.prepared.measured,
                c.before,
                c.after,
                floor.rms,
                position,
                name,
                (floor.edges, floor.density),
            )
        )
    return traces


def _motion(d: Diagnosis, prepared: PreparedRun) -> tuple[np.ndarray, str]:
    """What the force answers to: depth of the ring, or travel of the drive."""
    twin, x = d.device.twin, prepared.measured
    if not isinstance(twin, BenchTwin):
        return d.device.phase_inputs(prepared)[0], "position"
    y = ring_poses(twin, x[:, _LENGTHS])[0][:, 1]
    if not prepared.run.contact:
        return y, "ring"
    return y - x[:, _TORSO_Y], "ring against torso"

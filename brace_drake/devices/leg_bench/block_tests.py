"""Rungs of the leg bench's substitution ladder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.isolation.block_tests import Rung
from brace_drake.isolation.phases import MotionSignals
from brace_drake.recording.recording import Run

_CUTOFF_HZ = 20.0
# At both ends of a run, which the low pass folds, s.
_END_S = 0.5


def leg_rungs(twin: LegBenchTwin) -> list[Rung]:
    """Controller and actuation."""

    def controller(prepared, x):
        if not twin.numbers.is_closed_loop:
            return None
        run = _with_channels(prepared.run, x)
        residual = x[:, 0] - twin.control_law(run)
        if twin.command_holds_external(prepared.run):
            residual = residual - run.channels.get("external_force_N", 0.0)
        residual = residual[np.isfinite(residual)]
        return lambda subject: residual

    def actuation(prepared, x):
        step = np.median(np.diff(prepared.run.time_s))
        position = low_pass(x[:, 1], _CUTOFF_HZ, 1.0 / step)
        velocity = np.gradient(position, step)
        inner = slice(int(_END_S / step), -int(_END_S / step))
        acceleration = np.gradient(velocity, step)[inner]
        force = low_pass(x[:, 0], _CUTOFF_HZ, 1.0 / step)[inner]

        def residual(subject):
            mass, viscous, offset = subject
            return force - (
                mass * acceleration + viscous * velocity[inner] + offset
            )

        return residual

    return [
        Rung("controller", "position, reference", "command", controller),
        Rung("actuation", "command, motion", "balance of forces", actuation),
    ]


def _with_channels(run: Run, x: np.ndarray) -> Run:
    channels = dict(run.channels)
    channels["force_command_N"], channels["position_m"] = x[:, 0], x[:, 1]
    return replace(run, channels=channels)


def leg_quantities(twin: LegBenchTwin, x: np.ndarray) -> dict[str, np.ndarray]:
    """What users ask for: command, N, and position, mm."""
    return {"force_error_N": x[:, [0]], "position_error_mm": 1e3 * x[:, [1]]}


def leg_signals(
    twin: LegBenchTwin, prepared: PreparedRun, subject: np.ndarray
) -> MotionSignals:
    """Reference, or else position, of a run; no force."""
    channels = prepared.run.channels
    position = channels.get("position_desired_m", channels["position_m"])
    return MotionSignals(position, None, None, position, "position")

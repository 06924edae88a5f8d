"""What each block of the leg bench answers alone to its recorded inputs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.declaration import BlockTest
from brace_drake.devices.leg_bench.twin import LegBenchTwin

_CUTOFF_HZ = 20.0
# At both ends of a run, which the low pass folds, s.
_END_S = 0.5


def leg_tests(twin: LegBenchTwin) -> list[BlockTest]:
    """Controller and actuation."""
    return [
        BlockTest(
            "controller",
            "position, reference",
            "command",
            partial(residual_of_controller, twin),
        ),
        BlockTest(
            "actuation",
            "command, motion",
            "balance of forces",
            residual_of_actuation,
        ),
    ]


def residual_of_controller(twin: LegBenchTwin, prepared, x: np.ndarray):
    """Commands minus the control law's for the recorded positions."""
    if not twin.numbers.is_closed_loop:
        return None
    read = {"force_command_N": x[:, 0], "position_m": x[:, 1]}
    run = replace(prepared.run, channels={**prepared.run.channels, **read})
    residual = x[:, 0] - twin.control_law(run)
    if twin.command_holds_external(prepared.run):
        residual = residual - run.channels.get("external_force_N", 0.0)
    residual = residual[np.isfinite(residual)]
    return lambda subject: residual


def residual_of_actuation(prepared, x: np.ndarray):
    """Commands minus what the recorded motion asks for."""
    step = np.median(np.diff(prepared.run.time_s))
    position = low_pass(x[:, 1], _CUTOFF_HZ, 1.0 / step)
    velocity = np.gradient(position, step)
    inner = slice(int(_END_S / step), -int(_END_S / step))
    acceleration = np.gradient(velocity, step)[inner]
    force = low_pass(x[:, 0], _CUTOFF_HZ, 1.0 / step)[inner]

    def residual(subject):
        mass, viscous, offset = subject
        asked = mass * acceleration + viscous * velocity[inner] + offset
        return force - asked

    return residual

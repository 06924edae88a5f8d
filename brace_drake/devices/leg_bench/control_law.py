"""What a drive's controller makes of its readings and reference.

The user declares gains as they are known to him, and how a controller works out
a velocity is seldom known at all. So a run may follow a controller of other
numbers, and is no wrong recording then.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from brace_drake.devices.declaration import ControlLaw
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.recording.recording import Run

_COMMAND, _EXTERNAL = "force_command_N", "external_force_N"
_POSITION, _DESIRED = "position_m", "position_desired_m"
# Part of the limit from which on a command may have been cut.
_NEAR_LIMIT = 0.999
# Samples that a controller's error or velocity may be late by.
_LATEST = 4
# Gains may be so many times more or less than declared.
_SPREAD = 2.0


class DriveControlLaw(ControlLaw):
    """Position and its reference to the command.

    Args:
        twin: With gains.
    """

    outputs = (_COMMAND,)
    by_output = ((_POSITION, _DESIRED),)
    is_exact = False

    def __init__(self, twin: LegBenchTwin):
        self._twin = twin

    def recompute(self, run: Run) -> np.ndarray:
        """The command (N, 1); as recorded where the loop is open, or where no
        reading was before.
        """
        recorded = run.channels[_COMMAND]
        if not self._twin.is_closed(run):
            return recorded[:, None]
        command = self._twin.control_law(run)
        if self._twin.command_holds_external(run):
            command = command + run.channels.get(_EXTERNAL, 0.0)
        command = np.where(np.isfinite(command), command, recorded)
        return self._at_limit(command, recorded)

    def refitted(self, run: Run) -> np.ndarray:
        """The command (N, 1) of the nearest controller of this kind.

        Error and velocity at any of the last samples, the integral of the
        error, the reference's velocity and the external force have gains of
        their own, none below zero; a controller counts where the first two
        are within a factor of two of the declared ones.
        """
        kp, kv = self._twin.numbers.control[:2]
        desired, recorded = run.channels[_DESIRED], run.channels[_COMMAND]
        step = float(np.median(np.diff(run.time_s)))
        error = kv * kp * (desired - run.channels[_POSITION])
        velocity = kv * np.gradient(run.channels[_POSITION], step)
        late = range(_LATEST)
        columns = [_delayed(error, k) for k in late]
        columns += [-_delayed(velocity, k) for k in late]
        columns += [kv * np.gradient(desired, step), np.cumsum(error) * step]
        columns += [np.ones(len(desired)), -np.ones(len(desired))]
        if _EXTERNAL in run.channels:
            columns += [_delayed(run.channels[_EXTERNAL], k) for k in late]
        terms = np.column_stack(columns)
        free = np.abs(recorded) < _NEAR_LIMIT * self._twin.numbers.control[2]
        size = np.maximum(np.sqrt(np.sum(terms[free] ** 2, axis=0)), 1e-30)
        gains, _ = nnls(terms[free] / size, recorded[free])
        gains = gains / size
        sums = gains[:_LATEST].sum(), gains[_LATEST : 2 * _LATEST].sum()
        if not all(1.0 / _SPREAD <= s <= _SPREAD for s in sums):
            return self.recompute(run)
        return self._at_limit(terms @ gains, recorded)

    def _at_limit(self, command: np.ndarray, recorded: np.ndarray):
        """A command (N, 1), limited where the recorded one is at its limit."""
        limit = self._twin.numbers.control[2]
        cut = np.clip(command, -limit, limit)
        is_cut = np.abs(recorded) >= _NEAR_LIMIT * limit
        return np.where(is_cut, cut, command)[:, None]


def _delayed(values: np.ndarray, samples: int) -> np.ndarray:
    """Values some samples late, the first one held."""
    held = np.full(samples, values[0])
    return np.concatenate([held, values])[: len(values)]

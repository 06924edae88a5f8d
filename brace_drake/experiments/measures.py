"""How well a run of the brace tracks, in the measures of Table 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.model.simulate_brace import BraceLog

# Where the paper ends an episode, equations (17) to (19).
FORCE_LIMIT_N = 50.0
DRIFT_LIMIT_M = 0.020


@dataclass(frozen=True)
class Tracking:
    """Measures of one ring over a run; rms is sqrt(mean((desired - actual)^2)).

    Attributes:
        y_rms, x_rms, z_rms: Position, m.
        vy_rms: Velocity, m/s.
        force_rms: F_y about its own final value, N: how smooth the contact is
            by the paper; a force that grows with the push counts as rough.
        force_end: F_y at the end, N.
        peak_force: Greatest |F_y|, N.
        peak_drift: Greatest |x| or |z|, m.
        peak_leg: Greatest force of any leg, N.
    """

    y_rms: float
    vy_rms: float
    x_rms: float
    z_rms: float
    force_rms: float
    force_end: float
    peak_force: float
    peak_drift: float
    peak_leg: float

    @property
    def within_limits(self) -> bool:
        """Whether 50 N and 20 mm on x and z are kept."""
        return (
            self.peak_force <= FORCE_LIMIT_N
            and self.peak_drift <= DRIFT_LIMIT_M
        )


def measure_tracking(log: BraceLog, ring: int) -> Tracking:
    """Measures of a ring, by its index from below.

    Poses are the plant's own, forces are as read.
    """
    off = log.desired[:, 0, ring, :3] - log.X[:, ring, :3]
    force = log.force[:, ring, 1]
    moved = log.X[:, ring, [0, 2]] - log.X[0, ring, [0, 2]]
    return Tracking(
        y_rms=rms(off[:, 1]),
        vy_rms=rms(log.desired[:, 1, ring, 1] - log.v[:, ring, 1]),
        x_rms=rms(off[:, 0]),
        z_rms=rms(off[:, 2]),
        force_rms=rms(force[-1] - force),
        force_end=float(force[-1]),
        peak_force=float(np.abs(force).max()),
        peak_drift=float(np.abs(moved).max()),
        peak_leg=float(np.abs(log.drive_force).max()),
    )


def rms(values: np.ndarray) -> float:
    """sqrt(mean(values^2))."""
    return float(np.sqrt(np.mean(np.square(values))))

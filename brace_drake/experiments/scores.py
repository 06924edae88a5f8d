"""What Table 1 and its neighbours say of a push, whoever made it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

# Where the paper ends an episode, equations (17) to (19).
FORCE_LIMIT_N = 50.0
DRIFT_LIMIT_M = 0.020
_START_S = 1.0


class Push(NamedTuple):
    """A push at N instants, SI units.

    Attributes:
        time: From the start of the push (N,).
        error: Desired minus actual position along the push, x and z (N, 3).
        rate_error: The same of the velocity along the push (N,).
        force: On the torso along the push (N,).
        stiffness: In use along the push (N,); nan where it is not known.
    """

    time: np.ndarray
    error: np.ndarray
    rate_error: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True)
class Score:
    """Measures of a push; rms is sqrt(mean((desired - actual)^2)).

    Attributes:
        y_rms, vy_rms: Position, m, and velocity, m/s, along the push.
        x_rms, z_rms: Position across it, m.
        force_rms: Force about its own final value, N: how smooth the contact
            is by the paper; a force that grows with the push counts as rough.
        force_end: At the end, N.
        peak_force: Greatest force, N.
        peak_drift: Greatest way across the push, along x or z, m.
        start_rate: Greatest error of the velocity in the first second, m/s.
        y_end: Error of the position at the end, m.
        stiffness, stiffness_low, stiffness_high: In use over the second half
            of the push: mean, least and most, N/m.
    """

    y_rms: float
    vy_rms: float
    x_rms: float
    z_rms: float
    force_rms: float
    force_end: float
    peak_force: float
    peak_drift: float
    start_rate: float
    y_end: float
    stiffness: float
    stiffness_low: float
    stiffness_high: float

    @property
    def across_rms(self) -> float:
        """Position across the push, x and z together, m."""
        return float(np.hypot(self.x_rms, self.z_rms))

    @property
    def within_limits(self) -> bool:
        """Whether 50 N and 20 mm on x and z are kept."""
        return (
            self.peak_force <= FORCE_LIMIT_N
            and self.peak_drift <= DRIFT_LIMIT_M
        )


# Of a push that has failed: what it did until then is no measure of a whole
# push.
FAILED = Score(*[np.inf] * 10, *[np.nan] * 3)


def score_push(push: Push) -> Score:
    """Measures of a whole push."""
    error, rate, force = push.error, push.rate_error, push.force
    settled = push.stiffness[len(push.stiffness) // 2 :]
    early = push.time <= _START_S
    return Score(
        y_rms=rms(error[:, 0]),
        vy_rms=rms(rate),
        x_rms=rms(error[:, 1]),
        z_rms=rms(error[:, 2]),
        force_rms=rms(force[-1] - force),
        force_end=float(force[-1]),
        peak_force=float(np.abs(force).max()),
        peak_drift=float(np.abs(error[:, 1:] - error[0, 1:]).max()),
        start_rate=float(np.abs(rate[early]).max()),
        y_end=float(abs(error[-1, 0])),
        stiffness=float(settled.mean()),
        stiffness_low=float(settled.min()),
        stiffness_high=float(settled.max()),
    )


def rms(values: np.ndarray) -> float:
    """sqrt(mean(values^2))."""
    return float(np.sqrt(np.mean(np.square(values))))

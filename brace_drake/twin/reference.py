"""The reference motion: logged samples, interpolated with derivatives."""

from __future__ import annotations

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.campaign.recording import Run


def reference_columns(ring: int) -> tuple[str, str, str]:
    """Channels of a ring's reference: y, m; y', m/s; y'', m/s^2."""
    return (
        f"ring{ring}_y_desired_m",
        f"ring{ring}_vy_desired_m_s",
        f"ring{ring}_ay_desired_m_s2",
    )


COLUMNS = reference_columns(2)


def MakeReference(time: np.ndarray, samples: np.ndarray) -> PiecewisePolynomial:
    """Cubic Hermite interpolation of y, y', y'' given at sample times.

    Each of y and y' is interpolated with its own logged derivative; y'' with
    the slopes of its neighbours.

    Args:
        time: Sample times (N,), s, increasing.
        samples: y, y', y'' (N, 3).

    Returns:
        A trajectory of three rows.
    """
    slopes = np.column_stack(
        [samples[:, 1], samples[:, 2], np.gradient(samples[:, 2], time)]
    )
    return PiecewisePolynomial.CubicHermite(time, samples.T, slopes.T)


def reference_at_ticks(
    time: np.ndarray, samples: np.ndarray, rate: float
) -> np.ndarray:
    """The reference at control ticks from the first to the last sample.

    Returns:
        y, y', y'' at each tick (ticks, 3), C order.
    """
    ticks = round((time[-1] - time[0]) * rate) + 1
    at = np.minimum(time[0] + np.arange(ticks) / rate, time[-1])
    trajectory = MakeReference(time, samples)
    return np.ascontiguousarray(trajectory.vector_values(at).T)


def reference_of_run(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Sample times from 0 (N,), s, and the logged reference (N, 3)."""
    return run.time_s - run.time_s[0], run.stack(COLUMNS)

"""The reference motion: logged samples, interpolated with derivatives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.core.errors import CampaignError
from brace_drake.recording.recording import Run


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


def references_of_rings(
    run: Run, rings: Sequence[int], owner: str
) -> Iterator[tuple[int, np.ndarray]]:
    """Each ring's index in `rings` with its logged reference (N, 3).

    Rings without a reference are left out.

    Args:
        run: With references of some rings.
        rings: Numbers of the rings that can move, bottom to top.
        owner: What the rings are of, for the message.

    Raises:
        CampaignError: A reference of a ring that cannot move.
    """
    for ring in (1, 2, 3):
        columns = reference_columns(ring)
        if columns[0] not in run.channels:
            continue
        if ring not in rings:
            raise CampaignError(
                f"{run.file}: {columns[0]} moves ring {ring}; moving rings of"
                f" the {owner}: {', '.join(map(str, rings))}"
            )
        yield list(rings).index(ring), run.stack(columns)


def reference_of_run(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Sample times from 0 (N,), s, and the logged reference (N, 3)."""
    return run.time_s - run.time_s[0], run.stack(COLUMNS)

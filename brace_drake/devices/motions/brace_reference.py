"""References of the whole brace: y of each ring, all else held at the start."""

from __future__ import annotations

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.core.errors import CampaignError
from brace_drake.devices.motions.reference import references_of_rings
from brace_drake.recording.recording import Run


def MakeBraceReference(
    run: Run, stages: list[int], start: np.ndarray
) -> PiecewisePolynomial:
    """X_d, X_d', X_d'' (18 S rows) from a run's references, time from 0.

    Cubic Hermite interpolation as `reference.MakeReference`: a cubic
    polynomial comes back exactly at any sampling. Coordinates without a
    reference stay at the start.

    Args:
        run: With the references of some of the rings.
        stages: Of the brace, bottom to top; ring i sits above stage i.
        start: Task coordinates at time 0 (6 S,).

    Raises:
        CampaignError: A reference of a ring that is not there, or none.
    """
    time = run.time_s - run.time_s[0]
    desired = np.zeros((len(time), 3, 6 * len(stages)))
    desired[:, 0] = start
    slopes = np.zeros_like(desired)
    found = False
    for i, samples in references_of_rings(run, stages, "scenario"):
        found, y = True, 6 * i + 1
        desired[:, :, y] = samples
        slopes[:, :2, y] = samples[:, 1:]
        slopes[:, 2, y] = np.gradient(samples[:, 2], time)
    if not found:
        raise CampaignError(f"{run.file}: no reference (ring2_y_desired_m)")
    rows = (len(time), -1)
    return PiecewisePolynomial.CubicHermite(
        time, desired.reshape(rows).T, slopes.reshape(rows).T
    )

"""Start values of the contact from a pad's recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.campaign.recording import Run
from brace_drake.errors import CampaignError

# Contact offsets that are tried, over twice the pad's excursion.
_OFFSETS = 81
# The rate is taken from a displacement averaged over this long, s, and the
# force with it: the start is that of the slow part.
_AVERAGE_S = 0.05
_MOST_SAMPLES = 4000


@dataclass(frozen=True)
class ContactEstimate:
    """Contact of the first guess.

    Attributes:
        stiffness: N/m.
        damping: N s/m.
        offset: Displacement at which the pad touches, m.
        depth_scale: Excursion of the pad, m.
        rate_scale: Root mean square of its rate, m/s.
    """

    stiffness: float
    damping: float
    offset: float
    depth_scale: float
    rate_scale: float


def estimate_contact(
    runs: Sequence[Run],
    stiffness: float | None = None,
    damping: float | None = None,
) -> ContactEstimate:
    """The contact that explains the slow part of recordings best.

    Over a grid of offsets d_0, F = k (d - d_0) + c d' is fitted with k, c >= 0
    where d > d_0, and F = 0 elsewhere. The grid reaches one excursion to the
    outside of the recorded displacements, for pads that never leave.

    Args:
        runs: To be fitted, together.
        stiffness, damping: Given values, which are kept.

    Raises:
        CampaignError: The pad never moves.
    """
    parts = [_slow_part(run) for run in runs]
    d, v, force = (np.concatenate(p) for p in zip(*parts, strict=True))
    low, high = float(d.min()), float(d.max())
    span = high - low
    if not span > 0.0:
        raise CampaignError("the pad does not move in any run with split: fit")
    best = None
    for offset in np.linspace(low - span, high, _OFFSETS, endpoint=False):
        k, c, cost = _fit_at(offset, d, v, force, stiffness, damping)
        if best is None or cost < best[0]:
            best = cost, k, c, float(offset)
    _, k, c, offset = best
    rate = float(np.sqrt(np.mean(v**2)))
    # Force that falls with depth, or none: what is left is its size.
    least = 1e-3 * max(float(np.ptp(force)), 1e-6) / span
    return ContactEstimate(max(k, least), c, offset, span, max(rate, 1e-9))


def _slow_part(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacement, rate and force of a run, averaged, and thinned."""
    time = run.time_s
    step = float(np.median(np.diff(time)))
    width = min(max(1, round(_AVERAGE_S / step)), max(1, len(time) // 8))
    columns = np.column_stack(
        [time, run.channels["displacement_m"], run.channels["force_N"]]
    )
    box = np.ones(width) / width
    smooth = [np.convolve(c, box, mode="valid") for c in columns.T]
    rate = np.gradient(smooth[1], smooth[0])
    every = max(1, len(rate) // _MOST_SAMPLES)
    return smooth[1][::every], rate[::every], smooth[2][::every]


def _fit_at(offset, d, v, force, stiffness, damping):
    """Stiffness, damping and the sum of squares for one contact offset."""
    inside = d > offset
    depth, rate, pressed = d[inside] - offset, v[inside], force[inside]
    k, c = _two_not_negative(depth, rate, pressed, stiffness, damping)
    predicted = np.maximum(k * depth + c * rate, 0.0)
    rest = pressed - predicted
    return k, c, float(rest @ rest + force[~inside] @ force[~inside])


def _two_not_negative(x, y, target, k, c) -> tuple[float, float]:
    """Least squares of k x + c y, neither negative, some given."""
    if k is None and c is None:
        xx, xy, yy = x @ x, x @ y, y @ y
        determinant = xx * yy - xy * xy
        if determinant > 1e-12 * xx * yy:
            k = (yy * (x @ target) - xy * (y @ target)) / determinant
            c = (xx * (y @ target) - xy * (x @ target)) / determinant
        if c is None or c < 0.0:
            c, k = 0.0, None
    if k is None:
        k = _one_not_negative(x, target - c * y)
    if c is None:
        c = _one_not_negative(y, target - k * x)
    return max(k, 0.0), max(c, 0.0)


def _one_not_negative(x, target) -> float:
    square = float(x @ x)
    return max(0.0, float(x @ target) / square) if square > 0.0 else 0.0

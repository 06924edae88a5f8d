"""Start values of the contact from a pad's recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.optimize import nnls

from brace_drake.core.errors import CampaignError
from brace_drake.recording.recording import Run
from brace_drake.scenario.pad_noise import rises_above_noise

# Contact offsets that are tried, over twice the pad's excursion.
_OFFSETS = 61
# Readings are averaged over this long, s: the start is that of the slow part.
_AVERAGE_S = 0.05
_MOST_SAMPLES = 3000
# Time constants of tissue that relaxes, s, beside which the damping is told.
_ARMS_S = (0.3, 2.0, 10.0)
# The linear stiffness keeps at least this share of the mean one.
_LEAST_SHARE = 0.2


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


@dataclass(frozen=True)
class _Slow:
    """The slow part of a run: sampling period, s, then d, d', F (M,)."""

    step: float
    displacement: np.ndarray
    rate: np.ndarray
    force: np.ndarray


def estimate_contact(
    runs: Sequence[Run],
    stiffness: float | None = None,
    damping: float | None = None,
) -> ContactEstimate:
    """The contact that explains the slow part of recordings best.

    Over a grid of offsets, F = k d + c d' + k_3 d^3 + sum k_i (d - z_i) with
    creep z_i' = (d - z_i) / tau_i is fitted, no coefficient negative, where
    d = displacement - offset > 0; elsewhere F = 0. The terms beyond k and c
    keep these two, and the offset, from standing in for them. The grid reaches
    one excursion outside of the recorded displacements, for pads that never
    leave.

    Args:
        runs: To be fitted, together.
        stiffness, damping: Given values, which are kept.

    Raises:
        CampaignError: The pad never moves, or the force never changes.
    """
    parts = [_slow_part(run) for run in runs]
    low = min(float(p.displacement.min()) for p in parts)
    high = max(float(p.displacement.max()) for p in parts)
    span = high - low
    if not span > 0.0:
        raise CampaignError("the pad does not move in any run with split: fit")
    size = max(float(np.ptp(p.force)) for p in parts)
    if not size > 0.0:
        raise CampaignError(
            "the force does not change in any run with split: fit"
        )
    for name in ("displacement_m", "force_N"):
        if not rises_above_noise([run.channels[name] for run in runs]):
            raise CampaignError(
                f"{name} shows no more than its noise in the runs with split:"
                " fit: record a pad that moves and touches"
            )
    fits = [
        _fit_at(float(offset), parts, (stiffness, damping))
        for offset in np.linspace(low - span, high, _OFFSETS, endpoint=False)
    ]
    _, k, c, offset = min(fits)
    rate = np.sqrt(np.mean(np.concatenate([p.rate for p in parts]) ** 2))
    # A force that falls with depth still has a size.
    least = 1e-3 * size / span
    return ContactEstimate(max(k, least), c, offset, span, max(rate, 1e-9))


def _slow_part(run: Run) -> _Slow:
    time = run.time_s
    step = float(np.median(np.diff(time)))
    width = min(max(1, round(_AVERAGE_S / step)), max(1, len(time) // 8))
    box = np.ones(width) / width
    columns = (time, run.channels["displacement_m"], run.channels["force_N"])
    slow = [np.convolve(c, box, mode="valid") for c in columns]
    rate = np.gradient(slow[1], slow[0])
    every = max(width, -(-len(rate) // _MOST_SAMPLES))
    thin = slice(None, None, every)
    return _Slow(step * every, slow[1][thin], rate[thin], slow[2][thin])


def _fit_at(offset, parts, given) -> tuple[float, float, float, float]:
    """Sum of squares, stiffness, damping, and the offset itself."""
    bases = [_basis(offset, part) for part in parts]
    basis = np.vstack(bases)
    force = np.concatenate([p.force for p in parts])
    values = np.zeros(basis.shape[1])
    free = np.ones(len(values), dtype=bool)
    for i, value in enumerate(given):
        if value is not None:
            values[i], free[i] = value, False
    size = np.maximum(np.linalg.norm(basis, axis=0), 1e-300)
    triangle = np.linalg.qr(
        np.column_stack([(basis / size)[:, free], force - basis @ values]),
        mode="r",
    )
    found, _ = nnls(triangle[:-1, :-1], triangle[:-1, -1])
    values[free] = found / size[free]
    rest = force - np.maximum(basis @ values, 0.0)
    k, c = values[:2]
    if given[0] is None:
        depth = basis[:, 0]
        mean = float(depth @ force) / max(float(depth @ depth), 1e-300)
        k = max(k, _LEAST_SHARE * mean)
    return float(rest @ rest), float(k), float(c), offset


def _basis(offset: float, part: _Slow) -> np.ndarray:
    """Depth, rate, depth cubed and the relaxing arms at each sample (M, 6)."""
    depth = np.maximum(part.displacement - offset, 0.0)
    inside = depth > 0.0
    columns = [depth, np.where(inside, part.rate, 0.0), depth**3]
    for tau in _ARMS_S:
        decay = np.exp(-part.step / tau)
        creep = scipy.signal.lfilter([0.0, 1.0 - decay], [1.0, -decay], depth)
        columns.append(np.where(inside, depth - creep, 0.0))
    return np.column_stack(columns)

"""Force-motion record of the bench's pad pair, as one spring and damper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.recording.recording import Run

_COLUMNS = ("time_s", "torso_y_m", "ring2_force_y_N")


@dataclass(frozen=True)
class ContactMotion:
    """Law: F = k u + c u', one k and c of one pad in every regime.

    Attributes:
        time_s: evenly spaced, middle of each block, shape (N,), s.
        compression_m: signed compression u of the pad pair, negative in a
            push along -y, shape (N,), m.
        force_N: force of the ring on the torso along y, shape (N,), N.
    """

    time_s: np.ndarray
    compression_m: np.ndarray
    force_N: np.ndarray


def signed_compression(relative_m: np.ndarray, preload_m: float) -> np.ndarray:
    """Law: u = max(0, preload + r) - max(0, preload - r).

    With r = y_ring - y_torso the pads at +y and -y are compressed by
    d+ = preload - r and d- = preload + r; N = k d + c d' where d > 0, and the
    force on the torso along y is F = N- - N+ = k u + c u'. A correction is a
    push along -y: r < 0, and the pad at +y is the one that is pressed further.
    While both pads touch u = 2 r, they act in parallel as 2 k and 2 c on r;
    when one has lifted u = r - preload or r + preload, a single k and c. So
    regressing F on u needs no choice of samples, is continuous where a pad
    lifts, and needs the preload only beyond that point. A negative preload is
    a gap. Left out: N never pulls, so a pad that is withdrawn fast lifts while
    0 < k d < -c d'; and the turning of ring and torso, small on this bench.

    Args:
        relative_m: r, any shape, m.
        preload_m: compression of each pad at rest, m.

    Returns:
        u, shape of `relative_m`, m.
    """
    return np.maximum(preload_m + relative_m, 0.0) - np.maximum(
        preload_m - relative_m, 0.0
    )


def contact_motion_from_run(
    run: Run,
    ring_y_m: np.ndarray,
    *,
    preload_m: float,
    resample_s: float = 0.05,
) -> ContactMotion:
    """Law: u from r = ring_y - torso_y, then block means of u and F.

    A difference of raw samples is noise: the marker's 0.05 mm over 5 ms is
    14 mm/s, more than any motion on the bench. The mean over a block is a low
    pass and a decimation in one. Both signals go through the same linear
    filter, so F = k u + c u' still holds between the means; u is taken before
    averaging because it is not linear in r where a pad lifts.

    Args:
        run: a recording with the torso present; its `torso_y_m` and
            `ring2_force_y_N` are used.
        ring_y_m: the ring's y from the leg lengths, zero at rest, shape (N,),
            m.
        preload_m: compression of each pad at rest, m; nominal or estimated.
        resample_s: length of a block, s; 50 ms is the paper's interval.

    Returns:
        The record, ready for a fit with mass 0.

    Raises:
        CampaignError: if the run has no contact, lacks a channel, or has a
            gap as long as a block.
    """
    if not run.contact:
        raise CampaignError(f"{run.file}: a free run has no contact to fit")
    missing = [name for name in _COLUMNS if name not in run.channels]
    if missing:
        raise CampaignError(f"{run.file}: no channel {', '.join(missing)}")
    ring_y = np.asarray(ring_y_m, dtype=float)
    torso_y = run.channels["torso_y_m"]
    if ring_y.shape != torso_y.shape:
        raise CampaignError(
            f"{run.file}: ring y has shape {ring_y.shape}, the recording "
            f"{torso_y.shape}"
        )
    signals = np.column_stack(
        [
            signed_compression(ring_y - torso_y, preload_m),
            run.channels["ring2_force_y_N"],
        ]
    )
    time_s, means = _block_means(run, signals, resample_s)
    return ContactMotion(time_s, means[:, 0], means[:, 1])


def _block_means(
    run: Run, signals: np.ndarray, resample_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """Means over consecutive blocks of time; the last, partial one is dropped.

    Args:
        run: for its times and its name.
        signals: shape (N, M).
        resample_s: length of a block, s.

    Returns:
        Middle of each block, shape (B,), s, and the means, shape (B, M).
    """
    elapsed = run.time_s - run.time_s[0]
    sample_s = float(np.median(np.diff(run.time_s)))
    if not resample_s >= sample_s:
        raise CampaignError(
            f"{run.file}: blocks of {resample_s} s are shorter than the "
            f"sampling interval, {sample_s:g} s"
        )
    # Half a sample keeps rounded times out of the block before.
    block = np.floor((elapsed + 0.5 * sample_s) / resample_s).astype(int)
    blocks = int(np.floor((elapsed[-1] + sample_s * 1.01) / resample_s))
    count = np.bincount(block, minlength=blocks)[:blocks]
    if blocks < 1 or (count == 0).any():
        raise CampaignError(
            f"{run.file}: no sample in a block of {resample_s} s"
        )
    sums = [
        np.bincount(block, weights=s, minlength=blocks)[:blocks]
        for s in signals.T
    ]
    middle = run.time_s[0] + resample_s * (np.arange(blocks) + 0.5)
    return middle - 0.5 * sample_s, np.column_stack(sums) / count[:, None]

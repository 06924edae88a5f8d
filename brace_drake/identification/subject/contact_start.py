"""Where a fit of the contact begins: the paper's regression on recordings.

The pair of pads is one spring and damper, F = k u + c u', with u the signed
compression; `nn_regression` fits k and c to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.devices.bench.recorded_motion import ring_poses
from brace_drake.devices.bench.rollout import LENGTHS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.identification.subject.nn_regression import (
    NnContactEstimate,
    fit_contact_nn,
)
from brace_drake.recording.recording import Campaign, Run

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


# Slower resampling loses the damping, faster one drowns it in marker noise.
_RESAMPLE_S = 0.2


@dataclass(frozen=True)
class ContactStart:
    """Estimates of one run by both discretisations of equation (2)."""

    run: str
    consistent: NnContactEstimate
    printed: NnContactEstimate


def contact_motion(twin: BenchTwin, run: Run) -> ContactMotion:
    """What the network learns of a run: compression of the pads, and force.

    Raises:
        CampaignError: The run has no contact, or lacks a channel.
    """
    poses, _ = ring_poses(twin.numbers, twin.measured(run)[:, LENGTHS])
    return contact_motion_from_run(
        run,
        poses[:, 1],
        preload_m=twin.numbers.contact[0, 5],
        resample_s=_RESAMPLE_S,
    )


def contact_starts(twin: BenchTwin, campaign: Campaign) -> list[ContactStart]:
    """The network's stiffness and damping from every moving fit run."""
    starts = []
    for run in campaign.split("fit"):
        if not run.contact:
            continue
        try:
            motion = contact_motion(twin, run)
            found = [
                fit_contact_nn(
                    motion.time_s,
                    motion.compression_m,
                    motion.force_N,
                    0.0,
                    discretisation=how,
                )
                for how in ("consistent", "printed")
            ]
        except BraceError:
            # A run without motion says nothing of the contact.
            continue
        starts.append(ContactStart(run.name, *found))
    return starts


def start_values(twin: BenchTwin, starts: list[ContactStart]) -> np.ndarray:
    """Nominal subject with the median k and c of the network, in limits."""
    values = np.array([p.nominal for p in twin.subject])
    if starts:
        stiffness = np.median([s.consistent.stiffness for s in starts])
        damping = np.median([s.consistent.damping for s in starts])
        for i, value in enumerate((stiffness, damping)):
            limits = twin.subject[i]
            # A start at a limit is no start.
            inside = limits.lower * 1.2, limits.upper / 1.2
            if inside[0] < inside[1]:
                values[i] = float(np.clip(value, *inside))
    return values

"""What the rings of a device are asked to do: one moves, or several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.motions.reference import (
    reference_at_ticks,
    references_of_rings,
)
from brace_drake.recording import Run
from brace_drake.recording.columns import BENCH_RINGS

# Of the paper's experiments, and the bench's only one.
(RING,) = BENCH_RINGS


def place_motion(
    motion: SafeMotion, rings: Sequence[int], ring: int = RING
) -> SafeMotion:
    """A motion of one ring as that of a device, whose other rings are held.

    Args:
        motion: With samples (N, 3), or placed already.
        rings: Numbers of the device's moving rings, bottom to top.
        ring: That moves.

    Returns:
        The motion with samples (N, 3, S).

    Raises:
        CampaignError: The device has no such ring.
    """
    if motion.samples.ndim == 3:
        return motion
    if ring not in rings:
        words = ", ".join(map(str, rings))
        raise CampaignError(
            f"motion {motion.name}: no ring {ring}; moving rings of the device:"
            f" {words}"
        )
    samples = np.zeros((len(motion.time), 3, len(rings)))
    samples[:, :, list(rings).index(ring)] = motion.samples
    return replace(motion, samples=samples, rings=tuple(rings))


def motion_of_rings(
    run: Run, rings: Sequence[int], meaning: str = ""
) -> SafeMotion:
    """A run's references as a motion; rings without one are held.

    Args:
        run: With the reference of one ring at least.
        rings: Numbers of the device's moving rings, bottom to top.
        meaning: In a few words.

    Raises:
        CampaignError: A reference of a ring that the device has not.
    """
    samples = np.zeros((len(run.time_s), 3, len(rings)))
    for i, reference in references_of_rings(run, rings, "device"):
        samples[:, :, i] = reference
    time = run.time_s - run.time_s[0]
    return SafeMotion(
        run.name,
        meaning,
        run.contact,
        run.motion,
        time,
        samples,
        tuple(rings),
    )


def desired_at_ticks(motion: SafeMotion, rate: float) -> np.ndarray:
    """y_d, y_d', y_d'' of each ring at each control tick (ticks, 3, S)."""
    samples = motion.samples.reshape((len(motion.time), 3, -1))
    return reference_at_ticks(motion.time, samples, rate)

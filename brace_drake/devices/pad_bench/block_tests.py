"""What each block of the pad bench answers alone to its recorded inputs."""

from __future__ import annotations

from functools import partial

import numpy as np

from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.declaration import BlockTest
from brace_drake.devices.pad_bench.twin import PadBenchTwin, simulate_pad

# Motion of tissue under a pad is slower than this, Hz.
_CUTOFF_HZ = 10.0
# Of a sensor off the tissue the mean over this long counts, s.
_LEAST_FREE_S = 0.5
# Samples are looked at in this many blocks, of no fewer than so many.
_BLOCKS, _LEAST_BLOCK = 200, 8
# Least part of a run's excursion over which the force must be seen to rest.
_LEAST_WAY = 0.03
# Deviations of the force from its value at the outermost displacement that
# mean touch, in standard deviations.
TOUCH = 5.0


def pad_tests(twin: PadBenchTwin) -> list[BlockTest]:
    """Contact and sensing, in the order of the signal."""
    return [
        BlockTest(
            "contact",
            "displacement of the pad",
            "force on it",
            partial(residual_of_contact, twin),
        ),
        BlockTest(
            "sensing", "no contact", "force reading", residual_of_sensing
        ),
    ]


def residual_of_contact(twin: PadBenchTwin, prepared, x: np.ndarray):
    """Force minus that of the nominal law, where the pad touches."""
    time = prepared.motion.time
    rate = 1.0 / np.median(np.diff(time))
    cutoff = min(_CUTOFF_HZ, 0.5 * rate)

    def residual(subject):
        numbers = twin.with_subject(subject)
        path = prepared.motion.path(None, twin.corner_share(subject))
        inside = path[:, 0] > subject[2]
        law = simulate_pad(numbers, time, path, twin.time_step)
        return low_pass(x[:, 0] - law, cutoff, rate)[inside]

    return residual


def residual_of_sensing(prepared, x: np.ndarray):
    """Means of the force over stretches off the tissue, in pieces of no less
    than half a second.
    """
    rate = 1.0 / np.median(np.diff(prepared.motion.time))
    least = max(1, round(_LEAST_FREE_S * rate))

    def residual(subject):
        at = np.flatnonzero(free_samples(prepared, subject[2]))
        stretches = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
        pieces = [
            piece
            for stretch in stretches
            if len(stretch) >= least
            for piece in np.array_split(stretch, len(stretch) // least)
        ]
        return np.array([x[p, 0].mean() for p in pieces])

    return residual


def free_samples(prepared, offset: float) -> np.ndarray:
    """Samples at which the pad is off the tissue, whatever its law (N,).

    The displacements outside of the contact offset and of the first one at
    which the force leaves the value that it has at the outermost: a fitted
    offset alone lies too deep where tissue stiffens.

    Args:
        prepared: The run.
        offset: Contact offset of the nominal fit, m.
    """
    displacement = prepared.motion.displacement
    blocks = _resting_blocks(
        displacement, prepared.measured[:, 0], prepared.floor.rms[0]
    )
    free = np.zeros(len(displacement), dtype=bool)
    if not blocks:
        return free
    edge = min(displacement[blocks[-1][-1]], offset)
    # A force that keeps its value says nothing where the pad rests.
    least = _LEAST_WAY * np.ptp(displacement) + TOUCH * prepared.motion.sigma
    if edge - displacement.min() < least:
        return free
    return displacement < edge


def _resting_blocks(
    displacement: np.ndarray, force: np.ndarray, sigma: float
) -> list[np.ndarray]:
    """Samples by displacement, in blocks, as far as the force rests.

    It rests until a block's mean, or one sample of a fast touch, differs from
    the first block's. The block before that holds samples of both.
    """
    order = np.argsort(displacement, kind="stable")
    width = max(_LEAST_BLOCK, len(order) // _BLOCKS)
    blocks = [order[i : i + width] for i in range(0, len(order), width)]
    rest = force[blocks[0]].mean()
    for i, block in enumerate(blocks):
        slow = abs(force[block].mean() - rest) / np.sqrt(2.0 / len(block))
        if max(slow, np.abs(force[block] - rest).max()) > TOUCH * sigma:
            return blocks[: max(0, i - 1)]
    return blocks

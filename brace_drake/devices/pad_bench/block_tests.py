"""Rungs of the pad bench's substitution ladder."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.pad_bench.twin import PadBenchTwin, simulate_pad
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.isolation.block_tests import Rung
from brace_drake.isolation.phases import MotionSignals

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
_TOUCH = 5.0


def pad_rungs(twin: PadBenchTwin) -> list[Rung]:
    """Contact and sensing, in the order of the signal."""

    def contact(prepared, x):
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

    def sensing(prepared, x):
        rate = 1.0 / np.median(np.diff(prepared.motion.time))
        shortest = max(1, round(_LEAST_FREE_S * rate))
        return lambda subject: _slow_part(
            x[:, 0], free_samples(prepared, subject[2]), shortest
        )

    return [
        Rung("contact", "displacement of the pad", "force on it", contact),
        Rung("sensing", "no contact", "force reading", sensing),
    ]


def free_samples(prepared: PreparedRun, offset: float) -> np.ndarray:
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
    least = _LEAST_WAY * np.ptp(displacement) + _TOUCH * prepared.motion.sigma
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
        if max(slow, np.abs(force[block] - rest).max()) > _TOUCH * sigma:
            return blocks[: max(0, i - 1)]
    return blocks


def _slow_part(force: np.ndarray, free: np.ndarray, least: int) -> np.ndarray:
    """Means of the force over free stretches, in pieces of `least` or more."""
    at = np.flatnonzero(free)
    stretches = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
    pieces = [
        piece
        for stretch in stretches
        if len(stretch) >= least
        for piece in np.array_split(stretch, len(stretch) // least)
    ]
    return np.array([force[p].mean() for p in pieces])


def pad_quantities(twin: PadBenchTwin, x: np.ndarray) -> dict[str, np.ndarray]:
    """What users ask for: the force of the pad, N."""
    return {"force_error_N": x}


def pad_signals(
    twin: PadBenchTwin, prepared: PreparedRun, subject: np.ndarray
) -> MotionSignals:
    """Displacement and force of a run; the pad touches where there is any."""
    force = prepared.measured[:, 0]
    touching = force[:, None] > _TOUCH * prepared.motion.sigma
    displacement = prepared.motion.displacement
    return MotionSignals(displacement, 0, touching, displacement, "position")

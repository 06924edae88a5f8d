"""Rungs of the pad bench's substitution ladder."""

from __future__ import annotations

import numpy as np

from brace_drake.gap.evaluation import PreparedRun
from brace_drake.gap.ladder import Rung, low_pass
from brace_drake.twin.pad_bench_twin import PadBenchTwin, simulate_pad

# Motion of tissue under a pad is slower than this, Hz.
_CUTOFF_HZ = 10.0
# A sensor that drifts is slower than this, Hz.
_SLOW_HZ = 1.0
# Least free time for a verdict on the sensor, s.
_LEAST_FREE_S = 0.5
# Deviations of the force from its value at the outermost displacement that
# mean touch, in standard deviations.
_TOUCH = 5.0


def pad_rungs(twin: PadBenchTwin) -> list[Rung]:
    """Contact and sensing, in the order of the signal."""

    def contact(prepared, x, subject):
        time, numbers = prepared.motion.time, twin.with_subject(subject)
        path = prepared.motion.path(None, twin.corner_share(subject))
        inside = path[:, 0] > subject[2]
        if not inside.any():
            return None
        law = simulate_pad(numbers, time, path, twin.time_step)
        rate = 1.0 / np.median(np.diff(time))
        cutoff = min(_CUTOFF_HZ, 0.5 * rate)
        return low_pass(x[:, 0] - law, cutoff, rate)[inside]

    def sensing(prepared, x, subject):
        time = prepared.motion.time
        rate = 1.0 / np.median(np.diff(time))
        free = free_samples(prepared, subject[2])
        if np.count_nonzero(free) < max(8.0, _LEAST_FREE_S * rate):
            return None
        return _slow_part(x[:, 0], free, rate)

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
    force = prepared.measured[:, 0]
    order = np.argsort(displacement, kind="stable")
    width = max(8, len(order) // 200)
    blocks = [order[i : i + width] for i in range(0, len(order), width)]
    sigma = _TOUCH * prepared.floor.rms[0]
    rest = force[blocks[0]].mean()
    # A slow part on average, and the one sample of a fast touch.
    left = [
        abs(force[b].mean() - rest) > sigma * np.sqrt(2.0 / width)
        or np.abs(force[b] - rest).max() > sigma
        for b in blocks
    ]
    left = np.flatnonzero(left)
    # The block of the touch, and the one before, hold samples of both.
    last = left[0] - 1 if len(left) else len(blocks)
    if last < 1:
        return np.zeros(len(order), dtype=bool)
    touch = displacement[blocks[last - 1][-1]]
    return displacement < min(touch, offset)


def _slow_part(force: np.ndarray, free: np.ndarray, rate: float) -> np.ndarray:
    """Means of the force over the free stretches, piece by piece."""
    length = max(1, round(rate / _SLOW_HZ))
    at = np.flatnonzero(free)
    stretches = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
    pieces = [
        part
        for stretch in stretches
        for part in np.array_split(stretch, max(1, len(stretch) // length))
    ]
    return np.array([force[p].mean() for p in pieces if len(p)])


def pad_quantities(twin: PadBenchTwin, x: np.ndarray) -> dict[str, np.ndarray]:
    """What users ask for: the force of the pad, N."""
    return {"force_error_N": x}


def pad_phase_inputs(prepared: PreparedRun):
    """Displacement and force of a run, for its phases."""
    return prepared.motion.displacement, prepared.measured[:, 0]

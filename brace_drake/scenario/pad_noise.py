"""Noise of a pad bench's instruments, from its recordings alone.

No datasheet tells it. Without repeats it is the white part of the readings;
where runs were repeated, their difference adds the slow part.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.campaign.recording import Run
from brace_drake.scenario.leg_bench import white_part

# Lower limits of the bands in which noise is taken as white, Hz; the last is
# open.
NOISE_EDGES_HZ = np.array([0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0])
# Readings are taken to be no better than this part of the range they cover:
# good load cells have a combined error of some 0.02 % of full scale.
_FINEST = 1e-4
# Values of a spectrum that make an average.
_LEAST_BINS = 8
# Coefficients of a fourth difference: what is smooth cancels.
_FOURTH = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
_MEDIAN_TO_SIGMA = 1.4826


def estimate_force_noise(runs: Sequence[Run], rate_hz: float) -> np.ndarray:
    """Noise of the force readings by band.

    Args:
        runs: Recordings, repeats among them or not.
        rate_hz: Sampling rate.

    Returns:
        (B,), N: standard deviation, in each band of NOISE_EDGES_HZ, of white
        noise that is as strong at all frequencies as this noise is there.
    """
    forces = [run.channels["force_N"] for run in runs]
    least = _FINEST * max((np.ptp(f) for f in forces), default=0.0)
    white = max((white_noise(f) for f in forces), default=0.0)
    sigma = np.full(len(NOISE_EDGES_HZ), max(white, least))
    by_file = {run.file: run for run in runs}
    pairs = [
        (by_file[run.repeat_of], run)
        for run in runs
        if run.repeat_of in by_file
    ]
    if not pairs:
        return sigma
    return np.maximum(sigma, _repeat_noise(pairs, rate_hz))


def estimate_displacement_noise(runs: Sequence[Run]) -> float:
    """Noise of the displacement readings, m; the largest of the runs."""
    displacements = [run.channels["displacement_m"] for run in runs]
    return max((white_noise(d) for d in displacements), default=0.0)


def white_noise(signal: np.ndarray) -> float:
    """Standard deviation of the white noise of a reading (N,).

    The smaller of two estimates, both of which a fast motion can only enlarge:
    the upper end of the spectrum, and the median size of fourth differences,
    to which a few corners mean nothing. Not less than what rounding makes.
    """
    differences = np.convolve(signal, _FOURTH, mode="valid")
    if len(differences) < _LEAST_BINS:
        return 0.0
    spread = _MEDIAN_TO_SIGMA * np.median(np.abs(differences))
    spread /= np.linalg.norm(_FOURTH)
    return float(max(min(spread, white_part(signal)), _rounding(signal)))


def _rounding(signal: np.ndarray) -> float:
    """Standard deviation of the rounding to the smallest step of a reading."""
    steps = np.diff(np.unique(signal))
    # Smaller steps are the decimals of the same number.
    steps = steps[steps > 1e-9 * np.ptp(signal)]
    return float(steps.min()) / np.sqrt(12.0) if len(steps) else 0.0


def _repeat_noise(pairs, rate_hz: float) -> np.ndarray:
    """Noise by band from the differences of repeated runs (B,), N."""
    frequency, power = [], []
    for first, second in pairs:
        rest = repeat_difference(first, second) / np.sqrt(2.0)
        transform = np.fft.rfft(rest)
        # The mean shows as the first bin.
        frequency.append(np.fft.rfftfreq(len(rest), 1.0 / rate_hz))
        power.append(np.abs(transform) ** 2 / len(rest))
    frequency, power = np.concatenate(frequency), np.concatenate(power)
    order = np.argsort(frequency, kind="stable")
    frequency, power = frequency[order], power[order]
    edges = np.append(NOISE_EDGES_HZ, np.inf)
    sigma = np.zeros(len(NOISE_EDGES_HZ))
    for b in range(len(sigma)):
        start, end = np.searchsorted(frequency, edges[b : b + 2])
        # Bands with few bins borrow from above, or, at the end, from below.
        end = max(end, min(start + _LEAST_BINS, len(power)))
        start = min(start, max(0, end - _LEAST_BINS))
        sigma[b] = np.sqrt(np.mean(power[start:end]))
    return sigma


def repeat_difference(first: Run, second: Run) -> np.ndarray:
    """Difference of the forces of two runs that should be the same (N,), N.

    What the difference of their displacements explains, by a stiffness and a
    damping, is not noise and is taken off.
    """
    samples = min(len(first.time_s), len(second.time_s))
    force, d = (
        second.channels[name][:samples] - first.channels[name][:samples]
        for name in ("force_N", "displacement_m")
    )
    step = float(np.median(np.diff(first.time_s)))
    basis = np.column_stack([d, np.gradient(d, step)])
    found, *_ = np.linalg.lstsq(basis, force, rcond=1e-9)
    return force - basis @ found

"""Noise of a pad bench's instruments, from its recordings alone.

No datasheet tells it. Without repeats it is the white part of the readings;
where runs were repeated, their difference adds the slow part.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.recording.recording import Run
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
# Fourth differences this many times the usual are corners of the motion.
_CORNER = 4.5
_CLEARLY_LESS = 0.8
# Variance of their mean square, relative, times the number of samples: twice
# the sum of their squared correlations.
_VARIANCE = 5.3


def estimate_force_noise(runs: Sequence[Run], rate_hz: float) -> np.ndarray:
    """Noise of the force readings by band.

    Args:
        runs: Recordings, repeats among them or not.
        rate_hz: Sampling rate.

    Returns:
        (B,), N: standard deviation, in each band of NOISE_EDGES_HZ, of white
        noise that is as strong at all frequencies as this noise is there.
    """
    columns = "force_N", "displacement_m"
    return estimate_noise_by_band(runs, columns, rate_hz)


def estimate_noise_by_band(
    runs: Sequence[Run], columns: tuple[str, str], rate_hz: float
) -> np.ndarray:
    """`estimate_force_noise` of any force (B,), in its unit.

    Args:
        columns: Of the force, and of the motion that it answers to.
    """
    forces = [run.channels[columns[0]] for run in runs]
    least = _FINEST * max((np.ptp(f) for f in forces), default=0.0)
    sigma = np.full(
        len(NOISE_EDGES_HZ), max(estimate_white_noise(forces), least)
    )
    by_file = {run.file: run for run in runs}
    pairs = [
        (by_file[run.repeat_of], run)
        for run in runs
        if run.repeat_of in by_file
    ]
    if not pairs:
        return sigma
    return np.maximum(sigma, _repeat_noise(pairs, columns, rate_hz))


def estimate_displacement_noise(runs: Sequence[Run]) -> float:
    """Noise of the displacement readings of all runs, m."""
    return estimate_white_noise([r.channels["displacement_m"] for r in runs])


def estimate_white_noise(signals: Sequence[np.ndarray]) -> float:
    """White noise of several signals: the upper end of what they allow.

    Their mean square and twice its standard error, so that a short recording
    does not pass its own motion for more than noise.
    """
    count = sum(len(s) for s in signals)
    if count == 0:
        return 0.0
    squares = sum(len(s) * white_noise(s) ** 2 for s in signals) / count
    return float(np.sqrt(squares * (1.0 + 2.0 * np.sqrt(_VARIANCE / count))))


def rises_above_noise(signals: Sequence[np.ndarray]) -> bool:
    """Whether any of several readings ranges farther than white noise of their
    own deviation and number would.
    """
    count = max(2, sum(len(s) for s in signals))
    chance = 2.0 * (np.sqrt(2.0 * np.log(count)) + 1.0)
    noise = estimate_white_noise(signals)
    if not noise:
        # Too short for that: the scatter of steps, to which a ramp adds none.
        steps = [np.diff(s) for s in signals]
        scatter = np.concatenate([d - np.mean(d) for d in steps])
        noise = float(np.std(scatter)) / np.sqrt(2.0)
    return any(float(np.ptp(s)) > chance * noise for s in signals)


def white_noise(signal: np.ndarray) -> float:
    """Standard deviation of the white noise of a reading (N,).

    From fourth differences, without those that a corner of the motion makes
    large, or, where that finds clearly less, the upper end of the spectrum:
    fast motion can only enlarge both. Not less than what rounding makes.
    """
    differences = fourth_differences(signal)
    if len(differences) < _LEAST_BINS:
        return 0.0
    typical = _MEDIAN_TO_SIGMA * np.median(np.abs(differences))
    usual = differences[np.abs(differences) <= _CORNER * typical]
    spread = float(np.sqrt(np.mean(usual**2))) if len(usual) else 0.0
    spectral = white_part(signal)
    if spectral < _CLEARLY_LESS * spread:
        spread = spectral
    return max(spread, _rounding(signal, differences))


def fourth_differences(signal: np.ndarray) -> np.ndarray:
    """Fourth differences, of white noise's own standard deviation (N - 4,)."""
    differences = np.convolve(signal, _FOURTH, mode="valid")
    return differences / np.linalg.norm(_FOURTH)


def _rounding(signal: np.ndarray, differences: np.ndarray) -> float:
    """Standard deviation of the rounding to the smallest step of a reading.

    0 for a path of straight pieces, whose values lie on a grid too, but whose
    fourth differences vanish.
    """
    least = 1e-9 * np.ptp(signal)
    steps = np.diff(np.unique(signal))
    # Smaller steps are the decimals of the same number.
    steps = steps[steps > least]
    moves = signal[4:] != signal[:-4]
    rough = np.abs(differences[moves]) > least
    if not len(steps) or not len(rough) or rough.mean() < 0.5:
        return 0.0
    return float(steps.min()) / np.sqrt(12.0)


def _repeat_noise(pairs, columns, rate_hz: float) -> np.ndarray:
    """Noise by band from the differences of repeated runs (B,), N."""
    frequency, power = [], []
    for first, second in pairs:
        rest = repeat_difference(first, second, columns) / np.sqrt(2.0)
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


def repeat_difference(
    first: Run, second: Run, columns: tuple[str, str]
) -> np.ndarray:
    """Difference of the forces of two runs that should be the same (N,), N.

    What the difference of their displacements explains, by a stiffness and a
    damping, is not noise and is taken off.
    """
    samples = min(len(first.time_s), len(second.time_s))
    force, d = (
        second.channels[name][:samples] - first.channels[name][:samples]
        for name in columns
    )
    step = float(np.median(np.diff(first.time_s)))
    basis = np.column_stack([d, np.gradient(d, step)])
    found, *_ = np.linalg.lstsq(basis, force, rcond=1e-9)
    return force - basis @ found

"""How far recordings of one drive or one pad reached, and motions within.

Nothing is known of how far such a machine may go but what its recordings
reached: no way here goes further or faster.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from brace_drake.devices.motions.parts import (
    PEAK_SPEED,
    growing_sine,
    multisine,
    product,
    ramp,
    steps,
)
from brace_drake.recording.recording import Run
from brace_drake.scenario.pad_noise import white_noise

# Of the range and of the speed, what motions use.
_RANGE, _SPEED = 0.95, 0.75
# s; no motion lasts longer, but as long as what was recorded.
_LONG = 60.0
# s, over which speeds are means and what lasts less does not count; longer
# where noise makes more than a share of the speed.
_SPAN, _NOISE_SHARE = 0.05, 0.1
# The largest of thousands of noisy readings, in standard deviations.
_LARGEST = 4.0
_REST = 0.5  # s, before a motion begins
# Of stairs, of the way to the far end; no two further apart than _STEP.
_LEVELS, _STEP = np.array([0.25, 0.6, 1.0, 0.7, 0.35]), 0.4
# Rates of a multisine, over the lowest.
_RATES = np.array([1.0, 2.3, 4.0, 6.3, 9.7, 14.0])
# Samples in a period at least; small reversals are that much faster.
_PER_PERIOD, _QUICKER = 12.0, 5.0


@dataclass(frozen=True)
class Reach:
    """What recordings reached, but for what lasted shorter than 50 ms.

    Attributes:
        start: Where they begin, m.
        low, high: Ends of the way, m.
        speed: The largest along it, m/s.
        force: The largest, without its sign, N.
        duration: Of the longest, s.
    """

    start: float
    low: float
    high: float
    speed: float
    force: float
    duration: float


@dataclass(frozen=True)
class Way:
    """A motion within a reach.

    Attributes:
        name: Identifier.
        meaning: What moves and how, in a few words.
        time: Sample times from 0 (N,), s.
        position: (N,), m.
    """

    name: str
    meaning: str
    time: np.ndarray
    position: np.ndarray


def recorded_reach(runs: Sequence[Run], way: str, force: str) -> Reach:
    """What runs reached.

    Args:
        runs: At least one.
        way: Channel of the position, m.
        force: Channel of the force, N.
    """
    ways = [_lasting(run.time_s, run.channels[way]) for run in runs]
    forces = [_lasting(run.time_s, run.channels[force]) for run in runs]
    speeds = [largest_speed(run.time_s, run.channels[way]) for run in runs]
    return Reach(
        float(np.median([y[0] for y in ways])),
        float(min(y.min() for y in ways)),
        float(max(y.max() for y in ways)),
        max(speeds),
        float(max(np.abs(f).max() for f in forces)),
        float(max(run.time_s[-1] - run.time_s[0] for run in runs)),
    )


def _lasting(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Readings (N,) without what lasts shorter than half a span."""
    return median_filter(values, _samples(time, _SPAN) | 1, mode="nearest")


def _samples(time: np.ndarray, span: float) -> int:
    samples = max(1, round(span / float(np.median(np.diff(time)))))
    return min(samples, len(time) - 1)


def largest_speed(time: np.ndarray, way: np.ndarray) -> float:
    """The largest mean speed over a span on which noise is little, m/s.

    Args:
        time: (N,), s.
        way: Positions (N,), m.
    """
    noise, span = _LARGEST * np.sqrt(2.0) * white_noise(way), _SPAN
    while True:
        n = _samples(time, span)
        mean = np.abs(way[n:] - way[:-n]) / (time[n:] - time[:-n])
        speed = float(mean.max())
        is_whole = n == len(time) - 1
        if is_whole or noise <= _NOISE_SHARE * speed * n * np.diff(time)[0]:
            return speed
        span *= 2.0


def ways_within(reach: Reach, rate: float) -> list[Way]:
    """Holds, stairs, reversals and a multisine, each of which ends at rest.

    Where what was recorded is slow for its length, they stay nearer to the
    start. None where nothing moved.

    Args:
        reach: To stay within.
        rate: Of the samples, Hz.
    """
    middle = 0.5 * (reach.low + reach.high)
    half = 0.5 * _RANGE * (reach.high - reach.low)
    speed = _SPEED * reach.speed
    if not (half > 0.0 and speed > 0.0):
        return []
    ends = np.array([middle - half, middle + half]) - reach.start
    far, mean = float(ends[np.abs(ends).argmax()]), middle - reach.start
    rise = PEAK_SPEED * abs(far) / speed
    longest = max(_LONG, reach.duration)
    # Part of the way to each point of a range lies within that range.
    part = min(1.0, 0.25 * (longest - 2.0 * _REST) / rise)
    far, mean, half, rise = (part * v for v in (far, mean, half, rise))
    duration = max(min(reach.duration, _LONG), 2.0 * _REST + 4.0 * rise)
    time = np.arange(round(duration * rate)) / rate
    ways = [
        *_presses(time, far, rise, duration),
        *_waves(time, mean, half, rise, speed, rate),
    ]
    start = f"from {1e3 * reach.start:.3g} mm "
    return [
        Way(
            name,
            start + meaning,
            time,
            np.clip(reach.start + y[:, 0], reach.low, reach.high),
        )
        for name, meaning, y in ways
    ]


def _presses(time, far, rise, duration):
    """Names, meanings and motions that begin and end at rest.

    Args:
        time: (N,), s.
        far: The way to the far end, m.
        rise: Time that a ramp there takes, s.
        duration: Of each motion, s.
    """
    slow = 0.5 * (duration - 2.0 * _REST)
    back = ramp(time, _REST, slow, far) - ramp(time, _REST + slow, slow, far)
    level, step = (duration - _REST) / len(_LEVELS), _STEP * rise
    stairs = steps(time, far * _LEVELS, level - step, step)
    by = f"by {1e3 * far:.3g} mm"
    yield "hold", f"{by} in {rise:.3g} s, held", ramp(time, _REST, rise, far)
    yield "slow_cycle", f"{by} and back, {slow:.3g} s each", back
    yield "stairs", f"on five levels {by} at most, {level:.3g} s each", stairs


def _waves(time, mean, half, rise, speed, rate):
    """Names, meanings and motions about the middle, which fade at the end.

    Args:
        time: (N,), s.
        mean: The way to the middle, m.
        half: The largest amplitude, m.
        rise: Time that a ramp to the far end takes, s.
        speed: The largest, m/s.
        rate: Of the samples, Hz.
    """
    about = f"about {1e3 * mean:.3g} mm off at"
    there = ramp(time, 0.0, rise, mean)
    fade = -ramp(time, time[-1] - rise, rise, 1.0)
    fade[:, 0] += 1.0
    fast = min(speed / (2.0 * np.pi * half), rate / _PER_PERIOD)
    slow = min(fast, max(fast / _QUICKER, 1.5 / time[-1]))
    quick = min(_QUICKER * fast, rate / _PER_PERIOD)
    small = min(half, speed / (2.0 * np.pi * quick))
    kinds = ("", half, fast), ("_slow", half, slow), ("_small", small, quick)
    for kind, size, at in kinds:
        wave = product(fade, growing_sine(time, 0.0, size, at, rise))
        meaning = f"up to {1e3 * size:.3g} mm {about} {at:.2g} Hz"
        yield f"reversal{kind}", meaning, there + wave
    # Together they are never faster than that.
    lowest = min(fast * np.mean(1.0 / _RATES), rate / _PER_PERIOD / _RATES[-1])
    rates = lowest * _RATES
    grow = product(fade, ramp(time, rise, rise, 1.0))
    wave = product(grow, multisine(time, half, rates))
    meaning = f"{about} {rates[0]:.2g} to {rates[-1]:.2g} Hz"
    yield "multisine", meaning, there + wave

"""How far recordings of one drive or one pad reached, and motions within.

Nothing is known of how far such a machine may go but what its recordings
reached: no motion goes further or faster, or takes more force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.campaign.recording import Run
from brace_drake.twin.motion_parts import (
    PEAK_SPEED,
    growing_sine,
    multisine,
    product,
    ramp,
    steps,
)

# Of the range and of the speed, what motions use.
_RANGE, _SPEED = 0.95, 0.75
_LONGEST = 60.0  # s
_SPAN = 0.05  # s, over which speeds are means
_REST = 0.5  # s, before a motion begins
# Of stairs, of the way to the far end; no two further apart than _STEP.
_LEVELS, _STEP = np.array([0.25, 0.6, 1.0, 0.7, 0.35]), 0.4
# Rates of a multisine, over the lowest.
_RATES = np.array([1.0, 2.3, 4.0, 6.3, 9.7, 14.0])
# Samples in a period at least; small reversals are that much faster.
_PER_PERIOD, _QUICKER = 12.0, 5.0


@dataclass(frozen=True)
class Reach:
    """What recordings reached.

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
    ways = [run.channels[way] for run in runs]
    speeds = [_largest_speed(run.time_s, run.channels[way]) for run in runs]
    forces = [np.nanmax(np.abs(run.channels[force])) for run in runs]
    return Reach(
        float(np.median([y[0] for y in ways])),
        float(min(np.nanmin(y) for y in ways)),
        float(max(np.nanmax(y) for y in ways)),
        float(max(speeds)),
        float(max(forces)),
        float(min(max(r.time_s[-1] - r.time_s[0] for r in runs), _LONGEST)),
    )


def _largest_speed(time: np.ndarray, way: np.ndarray) -> float:
    """As the mean over a span on which noise is small."""
    span = max(1, round(_SPAN / float(np.median(np.diff(time)))))
    span = min(span, len(time) - 1)
    mean = (way[span:] - way[:-span]) / (time[span:] - time[:-span])
    return float(np.nanmax(np.abs(mean)))


def ways_within(reach: Reach, rate: float) -> list[Way]:
    """Holds, stairs, reversals and a multisine; none where nothing moved.

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
    duration = max(reach.duration, 2.0 * _REST + 4.0 * rise)
    time = np.arange(round(duration * rate)) / rate
    ways = [
        *_presses(time, far, rise, duration),
        *_waves(time, mean, half, rise, speed, rate),
    ]
    return [Way(n, m, time, reach.start + y[:, 0]) for n, m, y in ways]


def _presses(time, far, rise, duration):
    """Names, meanings and motions that begin and end at rest."""
    slow = 0.5 * (duration - 2.0 * _REST)
    back = ramp(time, _REST, slow, far) - ramp(time, _REST + slow, slow, far)
    level = (duration - _REST) / len(_LEVELS)
    step = min(_STEP * rise, 0.5 * level)
    stairs = steps(time, far * _LEVELS, level - step, step)
    mm = f"{1e3 * far:.3g} mm"
    yield "hold", f"{mm} in {rise:.3g} s, held", ramp(time, _REST, rise, far)
    yield "slow_cycle", f"{mm} and back, {slow:.3g} s each", back
    yield "stairs", f"five levels up to {mm}, {level:.3g} s each", stairs


def _waves(time, mean, half, rise, speed, rate):
    """Names, meanings and motions about the middle."""
    fast = min(speed / (2.0 * np.pi * half), rate / _PER_PERIOD)
    slow = max(fast / _QUICKER, 1.5 / time[-1])
    quick = min(_QUICKER * fast, rate / _PER_PERIOD)
    small = min(half, speed / (2.0 * np.pi * quick))
    kinds = ("", half, fast), ("_slow", half, slow), ("_small", small, quick)
    for kind, size, at in kinds:
        meaning = f"up to {1e3 * size:.3g} mm about the middle at {at:.2g} Hz"
        wave = growing_sine(time, mean, size, at, rise)
        yield f"reversal{kind}", meaning, wave
    # All its speeds at once are the speed.
    rates = _RATES * min(
        fast * np.mean(1.0 / _RATES), rate / _PER_PERIOD / _RATES[-1]
    )
    wave = product(ramp(time, rise, rise, 1.0), multisine(time, half, rates))
    meaning = f"{rates[0]:.2g} to {rates[-1]:.2g} Hz about the middle"
    yield "multisine", meaning, ramp(time, 0.0, rise, mean) + wave

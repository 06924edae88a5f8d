"""Checks of a recording's samples: time, units, stuck and clipped channels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.recording.columns import LATEST_S, Channel
from brace_drake.recording.dropouts import can_fill, lost_rows
from brace_drake.recording.findings import Problem, at_rows, error, warning
from brace_drake.recording.table import Columns

_RATE_TOLERANCE = 0.02
_GAP_PERIODS = 1.5
# Fewer rows tell nothing of their recorder.
TELLING_ROWS = 50
LEAST_STEP_S = 1e-7
_FLAT_SAMPLES = 5
# Digits of a time that may be rounded, how exactly such times are multiples of
# the last one, and how far off a line through them is, in that digit.
_MOST_DIGITS, _DIGIT_ERROR, _LINE_ERROR = 7, 1e-4, 0.05
# A run lasts minutes: what seems to last more than a day is in another unit.
LONGEST_S = 1e5


@dataclass(frozen=True)
class Limits:
    """Where commands and force readings are clipped.

    Attributes:
        command: Greatest force command of a leg, N; None when unknown.
        reading: Full scale of the force sensor, N.
        reading_step: Resolution of the force sensor, N.
    """

    command: float | None = 120.0
    reading: float = 50.0
    reading_step: float = 0.0245


def check_time(time: np.ndarray, rate_hz: float, file: str) -> list[Problem]:
    """Order, rate and gaps of the sample times.

    Args:
        time: Shape (N,), s.
        rate_hz: As campaign.yaml has it; NaN when that is unusable.
        file: The recording.
    """
    problems = []
    # Told with the channel's range: no order can be seen there.
    if not np.all(np.abs(time[np.isfinite(time)]) <= LATEST_S):
        return problems
    time = np.where(np.isfinite(time), time, np.nan)
    steps = np.diff(time, prepend=np.nan)
    tiny = (steps > 0) & (steps < LEAST_STEP_S)
    if tiny.any():
        step = steps[int(np.argmax(tiny))]
        message = f"a step of {step:g} s; allowed: {LEAST_STEP_S:g} s or more"
        return [at_rows(file, "time_s", tiny, message)]
    if np.any(steps <= 0):
        message = "time does not increase here"
        problems.append(at_rows(file, "time_s", steps <= 0, message))
    forward = steps[steps > 0]
    if np.isnan(rate_hz) or forward.size == 0:
        return problems
    period = float(np.median(forward))
    if abs(period * rate_hz - 1.0) > _RATE_TOLERANCE:
        message = (
            f"sampled at {1.0 / period:.6g} Hz, but rate_hz is {rate_hz:.6g}"
        )
        if 900.0 < period * rate_hz < 1100.0:
            message += ": is the time in milliseconds?"
        problems.append(error(file, message, "time_s"))
    since = time - time[np.isfinite(time)][0]
    if np.any(since > LONGEST_S):
        late = since[int(np.argmax(since > LONGEST_S))]
        message = (
            f"{late:.6g} s after the first row; allowed: {LONGEST_S:g} s or"
            " less; is the unit s?"
        )
        problems.append(at_rows(file, "time_s", since > LONGEST_S, message))
        return problems
    # With a wrong rate_hz every step would be a gap: use the true period.
    gaps = steps > _GAP_PERIODS * max(period, 1.0 / rate_hz)
    # A row that is early leaves a gap behind it that is none.
    gaps[1:] &= ~(steps[:-1] <= 0)
    if gaps.any():
        step = steps[int(np.argmax(gaps))]
        message = f"gap in time: {step:.4g} s before this row"
        fills = bool(np.all(steps[1:] > 0)) and can_fill(lost_rows(time))
        problems.append(at_rows(file, "time_s", gaps, message, fills))
    return problems


def since_first_row(time: np.ndarray) -> np.ndarray:
    """Sample times (N,) from 0, as a run may begin at any time of a clock;
    those of no clock as they are.
    """
    return time - time[0] if abs(time[0]) <= LATEST_S else time


def without_rounding(time: np.ndarray) -> np.ndarray:
    """Even sample times (N,) where nothing but rounding sets them apart.

    At 128 Hz times in whole milliseconds are up to 0.5 ms off, and slopes of
    what moves by up to a tenth. The even times are those of the straight line
    through them. Others stay as they are: no clock ticks evenly to the digit,
    and a lost row leaves a gap.
    """
    if len(time) < TELLING_ROWS or not np.all(np.abs(time) <= LATEST_S):
        return time
    steps = np.diff(time)
    if np.max(steps) > _GAP_PERIODS * np.median(steps):
        return time
    since = time - time[0]
    for digits in range(_MOST_DIGITS):
        scaled = since * 10.0**digits
        if np.all(np.abs(scaled - np.round(scaled)) < _DIGIT_ERROR):
            break
    else:
        return time
    rows = np.arange(len(time))
    even = np.polyval(np.polyfit(rows, since, 1), rows)
    off, digit = float(np.abs(even - since).max()), 10.0**-digits
    is_rounding = _DIGIT_ERROR * digit < off <= (0.5 + _LINE_ERROR) * digit
    return time[0] + even if is_rounding else time


def check_channel(
    columns: Columns,
    channel: Channel,
    contact: bool,
    limits: Limits | None,
    file: str,
) -> list[Problem]:
    """What a channel's values cannot be, by its declaration.

    Args:
        columns: With that of the channel.
        channel: The declaration.
        contact: Whether the torso is there.
        limits: Where values are clipped, None when it is unknown.
        file: The recording.
    """
    values = columns[channel.name]
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return []
    low, high = finite.min(), finite.max()
    problems = []
    if low < channel.low or high > channel.high:
        problems.append(check_range(values, channel, file))
    if low == high:
        if not _may_rest(columns, channel, contact):
            message = f"constant at {low:g} over the whole run"
            problems.append(warning(file, message, channel.name))
    elif channel.saturates and limits is not None and not problems:
        problems += check_saturation(values, channel, limits, file)
    return problems


def check_range(
    values: np.ndarray, channel: Channel, file: str
) -> Problem | None:
    """Values no such channel can hold: mostly a wrong unit."""
    low, high = channel.low, channel.high
    outside = (values < low) | (values > high)
    outside &= np.isfinite(values)
    if not outside.any():
        return None
    value = values[int(np.argmax(outside))]
    message = (
        f"{value:g} is outside the plausible range {low:g} .. {high:g}: "
        f"is the unit {channel.unit}?"
    )
    return at_rows(file, channel.name, outside, message)


def is_constant(values: np.ndarray) -> bool:
    """Whether two or more finite values are all the same."""
    values = values[np.isfinite(values)]
    return values.size > 1 and bool(np.all(values == values[0]))


def _may_rest(columns: Columns, channel: Channel, contact: bool) -> bool:
    """Whether a channel may stay at one value in this run."""
    if channel.constant == "still":
        reference = columns.get(channel.reference)
        return reference is None or is_constant(reference)
    return channel.constant == "always" or (
        channel.constant == "free" and not contact
    )


def check_saturation(
    values: np.ndarray, channel: Channel, limits: Limits, file: str
) -> list[Problem]:
    """Warns about samples at a limit, known or seen as a flat top."""
    size = np.abs(np.nan_to_num(values))
    if channel.saturates == "reading":
        limit = limits.reading
        clipped = size >= limit - limits.reading_step
        place = f"at the sensor's full scale of {limit:g} N"
    else:
        limit = limits.command
        clipped = flat_extremes(values)
        place = "flat at the channel's extreme value"
        if limit is not None and np.count_nonzero(size >= limit - 1e-3) > 1:
            clipped = size >= limit - 1e-3
            place = f"at the force limit of {limit:g} N"
    number = np.count_nonzero(clipped)
    if number < 2:
        return []
    message = f"saturated: {number} samples {place}"
    row = int(np.argmax(clipped)) + 1
    return [Problem("warning", file, message, row, channel.name)]


def flat_extremes(values: np.ndarray) -> np.ndarray:
    """Marks stretches that sit exactly at the greatest or least value.

    A stretch counts when it is reached and left by a step that is not
    small against the channel's range: a signal that settles to its extreme,
    or rests there before it starts, is not clipped.

    Args:
        values: Samples of one channel, shape (N,).

    Returns:
        Marks, shape (N,), bool.
    """
    marks = np.zeros(values.shape, dtype=bool)
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return marks
    least_step = 1e-3 * np.ptp(finite)
    for extreme in (finite.min(), finite.max()):
        edges = np.diff((values == extreme).astype(int), prepend=0, append=0)
        starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        for start, end in zip(starts, ends, strict=True):
            if end - start < _FLAT_SAMPLES or start == 0 or end == len(values):
                continue
            entry = abs(values[start] - values[start - 1])
            exit_ = abs(values[end] - values[end - 1])
            if min(entry, exit_) > least_step:
                marks[start:end] = True
    return marks

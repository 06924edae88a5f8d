"""The reference against its own derivatives: clock, scale and continuity.

A recorded y, y', y'' is one function of time, so

    y(n + 1) - y(n) = h (y'(n) + y'(n + 1)) / 2 - h^2 (y''(n + 1) - y''(n)) / 12

to fourth order in h, and y' and y'' likewise to second. Only the rounding of
the columns comes on top, so a factor or a jump is seen at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.channels import (
    reversed_sign,
    wrong_scale,
)
from brace_drake.recording_faults.library.runs import contradiction
from brace_drake.recording_faults.library.time import (
    lost_samples,
    wrong_clock,
)

# Time over which increments are compared, s, and how many are needed.
_WINDOW_S, _LEAST = 0.25, 20
# Crystals of recorders agree to 1e-4; what rounding makes comes on top.
_CLOCK = 5e-4
# Corners of y'' between samples: less of it is not told.
_GROSS = 0.1
# Slower than this part of the greatest speed nothing is told.
_SLOW = 0.2
# Jumps in units of what rounding and corners can make.
_JUMP = 4.0
# Columns whose increments scatter by more are no derivatives of each other.
_SCATTER = 0.1


@dataclass(frozen=True)
class Ratio:
    """Increments of a column over the integral of its derivative's.

    Attributes:
        value: Their median ratio.
        error: Its standard error.
        scatter: Median deviation of single increments, relative.
    """

    value: float
    error: float
    scatter: float

    @property
    def relative_error(self) -> float:
        """Of the value."""
        return self.error / max(abs(self.value), 1e-12)

    def is_one(self, least: float = _CLOCK) -> bool:
        """Whether nothing but rounding, or less than `least`, is off."""
        return abs(self.value - 1.0) <= max(least, 5.0 * self.error)


def ring_references(run: Run) -> Iterator[tuple[str, str, str]]:
    """Columns y, y', y'' of each ring that a run has them of."""
    for name in run.channels:
        if not (name.startswith("ring") and name.endswith("_y_desired_m")):
            continue
        ring = name.split("_")[0]
        found = (name, f"{ring}_vy_desired_m_s", f"{ring}_ay_desired_m_s2")
        if all(n in run.channels for n in found):
            yield found


def increment_ratio(
    values: np.ndarray, slopes: np.ndarray, h: float
) -> Ratio | None:
    """How the increments of a column compare with its derivative's integral.

    None where it hardly moves.
    """
    lag = max(1, round(_WINDOW_S / h))
    if len(values) <= 2 * lag:
        return None
    middle = 0.5 * h * (slopes[1:] + slopes[:-1])
    integral = np.concatenate([[0.0], np.cumsum(middle)])
    # The trapezoid's error telescopes: what the slopes' own slope changes.
    integral = integral - h * h / 12.0 * np.gradient(slopes, h)
    asked = integral[lag:] - integral[:-lag]
    found = values[lag:] - values[:-lag]
    noise = quantum_of(values) + h * np.sqrt(lag) * quantum_of(slopes)
    clear = np.abs(asked) > max(_SLOW * np.abs(asked).max(), 20.0 * noise)
    if np.count_nonzero(clear) < _LEAST:
        return None
    ratios = found[clear] / asked[clear]
    value = float(np.median(ratios))
    away = np.median(np.abs(ratios - value))
    independent = max(1.0, len(ratios) / lag)
    error = 1.25 * 1.4826 * away / np.sqrt(independent)
    scatter = float(away / max(abs(value), 1e-12))
    return Ratio(value, float(error), scatter)


def find_reference_faults(run: Run) -> list[Finding]:
    """Faults of clock, scale and continuity in a run's references."""
    found: list[Finding] = []
    h = float(np.median(np.diff(run.time_s)))
    for names in ring_references(run):
        y, v, a = (run.channels[n] for n in names)
        first, second = increment_ratio(y, v, h), increment_ratio(v, a, h)
        faults = _of_ratios(run, names, first, second, h)
        found += faults or _jumps(run, y, v, a, h)
    return found


def spread_clock(
    findings: Sequence[Finding], runs: Sequence[Run]
) -> list[Finding]:
    """Clocks that are off alike, as of all runs whose references allow it.

    A recorder has one clock; runs whose reference is at rest, or whose y' is
    not its slope, cannot tell.
    """
    clocks = [f for f in findings if f.fault is wrong_clock.CARD]
    if len(clocks) < 2:
        return list(findings)
    ratios = np.array([f.parameters["rate_ratio"] for f in clocks])
    ratio = float(np.median(ratios))
    same = np.abs(ratios - ratio) < 0.3 * abs(ratio - 1.0)
    others = {f.runs[0] for f, s in zip(clocks, same, strict=True) if not s}
    allowed = [r for r in runs if r.file not in others and _allows(r, ratio)]
    first = clocks[int(np.argmax(same))]
    rate = first.parameters["true_rate_hz"]
    rate *= first.parameters["rate_ratio"] / ratio
    values = {"rate_ratio": ratio, "true_rate_hz": rate}
    files = {r.file for r in allowed}
    kept = [f for f in findings if not (f in clocks and f.runs[0] in files)]
    # What else was seen in the same references is the clock's.
    kept = [
        f
        for f in kept
        if f.fault is not lost_samples.CARD or f.runs[0] not in files
    ]
    return kept + [
        replace(first, runs=(r.file,), parameters=values) for r in allowed
    ]


def _allows(run: Run, ratio: float) -> bool:
    """Whether a run's references are silent of a clock, or agree with it."""
    h = float(np.median(np.diff(run.time_s)))
    for names in ring_references(run):
        y, v, _ = (run.channels[n] for n in names)
        found = increment_ratio(y, v, h)
        if found is None or found.scatter > 0.2 * abs(ratio - 1.0):
            continue
        if abs(found.value - ratio) > 0.5 * abs(ratio - 1.0):
            return False
    return True


def _of_ratios(run, names, first, second, h) -> list[Finding]:
    """What two ratios of increments say: clock, a scale, a contradiction."""
    if first is None:
        return []
    if first.is_one() and (second is None or second.is_one(_GROSS)):
        return []
    if first.scatter > _SCATTER or (second and second.scatter > 3 * _SCATTER):
        detail = f"{names[1]} is not the derivative of {names[0]}"
        return [_unlike(run, names, detail)]
    r, s = first.value, second.value if second else first.value
    seen = f"{names[0]} moves {r:.5g} times as fast as {names[1]} says"
    errors = [x.relative_error for x in (first, second) if x]
    near = min(5.0 * max(_CLOCK, *errors), _GROSS)
    # Steps of h are in truth h r long where y seems r times as fast. Corners
    # of y'' blur what y' says of it: then a small factor is the clock's.
    blurred = not first.is_one() and abs(r - 1.0) < near
    if r > 0.0 and (abs(s / r - 1.0) < near or blurred):
        values = {"rate_ratio": r, "true_rate_hz": 1.0 / (h * r)}
        return [_finding(wrong_clock.CARD, run, (), values, seen, 0.98)]
    near = max(near, 0.02)
    if abs(s - 1.0) < near:
        return [_scaled(run, names[0], r, seen)]
    if abs(s * r - 1.0) < near * max(1.0, abs(r * s)):
        if abs(r + 1.0) < near:
            seen += ", or all rows are in the opposite order"
        return [_scaled(run, names[1], 1.0 / r, seen)]
    if abs(r - 1.0) < near:
        seen = f"{names[1]} changes {s:.5g} times as fast as {names[2]} says"
        return [_scaled(run, names[2], 1.0 / s, seen)]
    return [_unlike(run, names, seen)]


def _unlike(run: Run, names: Sequence[str], detail: str) -> Finding:
    """Columns that are no derivatives of each other: some references are made
    so, and the controller has followed them as they are.
    """
    found = _finding(contradiction.CARD, run, names, {}, detail, 0.9)
    return replace(found, severity="warning")


def _scaled(run: Run, name: str, scale: float, seen: str) -> Finding:
    if abs(scale + 1.0) < 0.02:
        return _finding(
            reversed_sign.CARD, run, (name,), {"zero": 0.0}, seen, 0.98
        )
    values = {"scale": scale, "zero": 0.0}
    return _finding(wrong_scale.CARD, run, (name,), values, seen, 0.98)


def _finding(card, run, channels, values, detail, probability, row=None):
    return Finding(
        card,
        (run.file,),
        tuple(channels),
        values,
        probability,
        detail,
        row=row,
    )


def _jumps(run: Run, y, v, a, h: float) -> list[Finding]:
    """Places where the reference leaps, as where samples are missing."""
    speed = 0.5 * (v[1:] + v[:-1])
    leap = np.diff(y) - h * speed + h * h / 12.0 * np.diff(a)
    corner = h * h / 4.0 * np.abs(np.diff(a))
    least = quantum_of(y) + h * quantum_of(v) + corner
    # A corner of the speed inside a step is missed by up to this.
    least = least + h / 4.0 * np.abs(np.diff(v) - h * 0.5 * (a[1:] + a[:-1]))
    # A reference whose y' is not its slope leaps in every step; samples are
    # lost in one, and those beside it know nothing of it.
    spike = np.zeros(len(leap))
    spike[1:-1] = leap[1:-1] - 0.5 * (leap[:-2] + leap[2:])
    marks = np.abs(spike) > _JUMP * np.maximum(least, 1e-9)
    marks[1:-1] &= np.minimum(
        np.abs(leap[1:-1] - leap[:-2]), np.abs(leap[1:-1] - leap[2:])
    ) > 0.5 * np.abs(spike[1:-1])
    # Time that is missing goes on, by half a sample at least.
    marks &= leap * np.sign(speed) > 0.5 * h * np.abs(speed)
    if not marks.any():
        return []
    at = int(np.argmax(marks))
    slow = max(abs(float(speed[at])), 1e-9)
    lost = float(np.clip(leap[at] / speed[at] if speed[at] else 0.0, -60, 60))
    start = float(run.time_s[at + 1] - run.time_s[0])
    count = int(marks.sum())
    detail = (
        f"the reference leaps {leap[at] * 1e3:.3g} mm at {start:.4g} s, where"
        f" it moves at {slow * 1e3:.3g} mm/s"
    )
    values = {"start_s": start, "lost_s": lost, "jumps": float(count)}
    card = lost_samples.CARD
    return [_finding(card, run, (), values, detail, 0.97, at + 2)]

"""What a reading must not show: each guard says which limit it passes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from brace_drake.link.protocol.limits import Limits, of_stage
from brace_drake.link.protocol.words import Cause

# Low pass of leg rates, s: a length's resolution over a tick is no speed.
SPEED_TAU = 0.02
# Of a stage.
LEGS = 6


# What a trip's index counts, from 1; factor and unit that its values are shown
# with.
_SHOWN = {
    Cause.WATCHDOG: ("", 1e3, "ms"),
    Cause.LEG_STROKE: ("leg", 1e3, "mm"),
    Cause.LEG_SPEED: ("leg", 1e3, "mm/s"),
    Cause.PAD_FORCE: ("moving ring", 1.0, "N"),
    Cause.TOTAL_FORCE: ("", 1.0, "N"),
    Cause.RING_POSE: ("moving ring", 1.0, "m or rad"),
    Cause.TRACKING: ("moving ring", 1.0, "m or rad"),
    Cause.STALE_DATA: ("", 1e3, "ms"),
    Cause.LOST_MESSAGES: ("", 1.0, "in a row"),
    Cause.JUMP: ("leg or moving ring", 1.0, "m or N"),
    Cause.DISAGREEMENT: ("", 1.0, "s"),
    Cause.STUCK_LEG: ("leg", 1e3, "mm"),
}


class Trip(NamedTuple):
    """A limit passed: cause, leg or ring from 0, value, limit, SI units."""

    cause: Cause
    index: int = 0
    value: float = 0.0
    limit: float = 0.0

    def __str__(self) -> str:
        words = self.cause.text
        if self.cause == Cause.DISARMED:
            return f"{words}: {self.cause.meaning}"
        if self.limit == 0.0:
            return words
        part, factor, unit = _SHOWN.get(self.cause, ("", 1.0, ""))
        value, limit = factor * self.value, factor * self.limit
        if self.cause == Cause.STALE_DATA:
            return (
                f"{words}: the newest reading is {value:.0f} {unit} old, limit"
                f" {limit:.0f} {unit} (`stale` of the limits): this computer"
                " is too slow or too busy"
            )
        at = f" ({part} {self.index + 1})" if part else ""
        return f"{words}: {value:.4g} {unit}, allowed {limit:.4g} {unit}{at}"


NO_TRIP = Trip(Cause.NONE)


def update_speed(
    speed: Sequence[float],
    before: Sequence[float],
    now: Sequence[float],
    elapsed: float,
) -> tuple[float, ...]:
    """Leg rates (n,), m/s: differences through a low pass of SPEED_TAU."""
    gain = 1.0 - math.exp(-elapsed / SPEED_TAU)
    return tuple(
        v + gain * ((b - a) / elapsed - v)
        for v, a, b in zip(speed, before, now, strict=True)
    )


def pad_force(force: Sequence[float], preload: float) -> float:
    """Force of the pad of a ring that presses harder, N.

    Both pads press with `preload` at rest. While both touch, their difference
    is the reading and their sum stays, so that the larger is |F_y| / 2 +
    preload; else one alone makes the reading.
    """
    along = abs(force[1])
    return max(along, 0.5 * along + preload)


def check_stroke(limits: Limits, length: Sequence[float]) -> Trip | None:
    """Legs shorter or longer than their stage's may be, or not a number."""
    for i in range(len(length) // LEGS):
        low = of_stage(limits.leg_shortest, i)
        high = of_stage(limits.leg_longest, i)
        for k in range(LEGS * i, LEGS * i + LEGS):
            value = length[k]
            if not low <= value <= high:
                bound = low if value < low else high
                return Trip(Cause.LEG_STROKE, k, value, bound)
    return None


def check_speed(limits: Limits, speed: Sequence[float]) -> Trip | None:
    """Legs faster than allowed."""
    most = limits.leg_speed
    for k, value in enumerate(speed):
        if not abs(value) <= most:
            return Trip(Cause.LEG_SPEED, k, abs(value), most)
    return None


def check_force(limits: Limits, force: Sequence[float]) -> Trip | None:
    """Force of each ring's pads, and of all rings together.

    Args:
        limits: Of which pad_force, pad_preload and total_force are used.
        force: Of each ring on the torso, W (3 S,), N.
    """
    total = 0.0
    for ring in range(len(force) // 3):
        on_ring = force[3 * ring : 3 * ring + 3]
        pad = pad_force(on_ring, limits.pad_preload)
        if not pad <= limits.pad_force:
            return Trip(Cause.PAD_FORCE, ring, pad, limits.pad_force)
        total += math.hypot(*on_ring)
    if not total <= limits.total_force:
        return Trip(Cause.TOTAL_FORCE, 0, total, limits.total_force)
    return None


def check_shared(
    limits: Limits,
    length: Sequence[float],
    speed: Sequence[float],
    force: Sequence[float],
) -> Trip | None:
    """What device and host both hold: stroke, speed, forces."""
    return (
        check_stroke(limits, length)
        or check_speed(limits, speed)
        or check_force(limits, force)
    )


def check_jump(
    limits: Limits,
    before: Sequence[float],
    now: Sequence[float],
    force_before: Sequence[float],
    force: Sequence[float],
    ticks: float,
) -> Trip | None:
    """Changes that no brace makes in so many ticks."""
    most = limits.length_jump * ticks
    for k, (a, b) in enumerate(zip(before, now, strict=True)):
        if not abs(b - a) <= most:
            return Trip(Cause.JUMP, k, abs(b - a), most)
    most = limits.force_jump * ticks
    for i, (a, b) in enumerate(zip(force_before, force, strict=True)):
        if not abs(b - a) <= most:
            return Trip(Cause.JUMP, i // 3, abs(b - a), most)
    return None


def check_pose(
    limits: Limits,
    pose: Sequence[float],
    virtual: Sequence[float] | None,
) -> Trip | None:
    """Displacement and rotation of each ring, and from its virtual pose.

    Args:
        limits: Of which ring_* and tracking_* are used.
        pose: X of each ring: displacement (3), m, rotation vector (3), rad.
        virtual: Virtual pose likewise, or None.
    """
    whole = Cause.RING_POSE, limits.ring_position, limits.ring_rotation
    behind = Cause.TRACKING, limits.tracking_position, limits.tracking_rotation
    for ring in range(len(pose) // 6):
        X = pose[6 * ring : 6 * ring + 6]
        away = [(whole, X)]
        if virtual is not None:
            X_v = virtual[6 * ring : 6 * ring + 6]
            away += [(behind, [a - b for a, b in zip(X, X_v, strict=True)])]
        for (cause, distance, angle), x in away:
            for most, part in ((distance, x[0:3]), (angle, x[3:6])):
                if not math.hypot(*part) <= most:
                    return Trip(cause, ring, math.hypot(*part), most)
    return None


def largest_disagreement(
    force: Sequence[float], expected: Sequence[float]
) -> float:
    """How far the reading of a ring is from what is expected, N."""
    return max(
        math.dist(force[i : i + 3], expected[i : i + 3])
        for i in range(0, len(force), 3)
    )

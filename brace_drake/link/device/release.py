"""What the legs get: commands within limits, or the damped release.

The release goes from a load to no stiffness within a stated time:

    f_k(t) = h_k + r(t / T) (f_k(0) - h_k) - d l_k',   r(s) = 1 - 3 s^2 + 2 s^3

with f(0) the command when it began, h what carries the rings' own weight, T
and d the limits `release_time` and `release_damping`. Behind T a torso pushes
a ring away against damping alone: it is neither dropped nor held under load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from brace_drake.link.protocol.limits import Limits


def remaining(t: float, duration: float) -> float:
    """r(t / T): 1 until t = 0, 0 from T on, smooth in between."""
    s = min(1.0, max(0.0, t / duration))
    return 1.0 - s * s * (3.0 - 2.0 * s)


def release_command(
    t: float,
    limits: Limits,
    start: Sequence[float],
    hold: Sequence[float],
    speed: Sequence[float],
) -> tuple[float, ...]:
    """Leg commands of a release (n,), N, each within the leg's limit.

    Args:
        t: Since the release began, s.
        limits: Their time, damping and leg force.
        start: Commands when it began (n,), N.
        hold: What carries the rings' weight at rest (n,), N.
        speed: Leg rates (n,), m/s.
    """
    r = remaining(t, limits.release_time)
    most, damping = limits.leg_force, limits.release_damping
    return tuple(
        min(most, max(-most, h + r * (f - h) - damping * v))
        for f, h, v in zip(start, hold, speed, strict=True)
    )


def limit_command(
    limits: Limits,
    before: Sequence[float],
    command: Sequence[float],
    elapsed: float,
) -> tuple[float, ...]:
    """Commands cut at the limits of leg force and of its rate (n,), N."""
    most, step = limits.leg_force, limits.leg_force_rate * elapsed
    return tuple(
        min(most, a + step, max(-most, a - step, b))
        for a, b in zip(before, command, strict=True)
    )


def cut_stiffness(
    limits: Limits,
    before: Sequence[float],
    stiffness: Sequence[float],
    elapsed: float,
) -> tuple[float, ...]:
    """Desired stiffness cut at its limits and rates (n,).

    Args:
        limits: Of which stiffness* and turn_stiffness* are used.
        before: What passed last; 0 throughout: none so far, no rate holds.
        stiffness: K_d of each ring: N/m (3), N m/rad (3). What is no number
            keeps the last value.
        elapsed: Since then, s.
    """
    first, out = not any(before), []
    for i, (last, wanted) in enumerate(zip(before, stiffness, strict=True)):
        turns = i % 6 >= 3
        most = limits.turn_stiffness if turns else limits.stiffness
        rate = limits.turn_stiffness_rate if turns else limits.stiffness_rate
        value = wanted if math.isfinite(wanted) else last
        value = min(most, max(0.0, value))
        if not first:
            step = rate * elapsed
            value = min(last + step, max(last - step, value))
        out.append(value)
    return tuple(out)

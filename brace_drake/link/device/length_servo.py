"""Commands of length: what a device does with them, leg by leg.

    f = h + k_p (l_r - l) + z - k_d l',   z' = k_i (l_r - l)

l_r follows the length asked for, clear of the stroke's limits (which stop) and
at no more than half of the limit `leg_speed`; h carries the rings' weight. The
gains suit the bench, its ring of 0.85 kg on six legs of 40 N s/m with or
without a torso, at 1 kHz; a drive of another mass has its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from brace_drake.link.device.guards import LEGS
from brace_drake.link.protocol.limits import Limits, of_stage

# N/m, N/(m s), N s/m; low pass of the rate, s.
_K_P, _K_I, _K_D, _TAU = 10e3, 150e3, 50.0, 0.003
# l_r keeps so far from the ends of the stroke, m.
_MARGIN = 0.5e-3
# Shares of limits: speed of the reference, force of the integral.
_SPEED, _INTEGRAL = 0.5, 0.5


class ServoMemory(NamedTuple):
    """What the servo remembers from tick to tick, (n,) each.

    Attributes:
        target: l_r, m.
        integral: z, N.
        length, rate: Measured last, m, and filtered, m/s.
    """

    target: tuple[float, ...]
    integral: tuple[float, ...]
    length: tuple[float, ...]
    rate: tuple[float, ...]


def start_servo(length: Sequence[float]) -> ServoMemory:
    """At rest where the legs are found."""
    zeros, length = (0.0,) * len(length), tuple(length)
    return ServoMemory(length, zeros, length, zeros)


def follow_lengths(
    limits: Limits,
    memory: ServoMemory,
    asked: Sequence[float],
    length: Sequence[float],
    hold: Sequence[float],
    period: float,
) -> tuple[ServoMemory, tuple[float, ...], bool]:
    """One tick.

    Args:
        limits: Stroke, speed and force of the legs.
        memory: Of the last tick.
        asked: Lengths (n,), m.
        length: Measured (n,), m.
        hold: What carries the rings' weight at rest (n,), N.
        period: s.

    Returns:
        Memory, leg forces (n,), N, and whether a length was cut.
    """
    step = _SPEED * limits.leg_speed * period
    most = _INTEGRAL * limits.leg_force
    gain = 1.0 - math.exp(-period / _TAU)
    target, integral, rate, force = [], [], [], []
    for k, wanted in enumerate(asked):
        low = of_stage(limits.leg_shortest, k // LEGS) + _MARGIN
        high = of_stage(limits.leg_longest, k // LEGS) - _MARGIN
        wanted = min(high, max(low, wanted))
        before = memory.target[k]
        target.append(min(before + step, max(before - step, wanted)))
        error = target[k] - length[k]
        z = memory.integral[k] + period * _K_I * error
        integral.append(min(most, max(-most, z)))
        change = (length[k] - memory.length[k]) / period
        rate.append(memory.rate[k] + gain * (change - memory.rate[k]))
        force.append(hold[k] + _K_P * error + integral[k] - _K_D * rate[k])
    memory = ServoMemory(*map(tuple, (target, integral, length, rate)))
    return memory, tuple(force), memory.target != tuple(asked)

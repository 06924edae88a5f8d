"""What is random in a run: instruments, breath, lost commands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from brace_drake.withheld.simulator import numbers
from brace_drake.withheld.simulator.flaws import Flaws

# Breath wanders in rate and depth by this much, within this time.
_WANDER, _WANDER_TIME = 0.08, 6.0


class Chance(NamedTuple):
    """What is random in a run of n ticks.

    Attributes:
        lengths, force: Noise of the instruments (n, 6), (n, 3), m, N.
        expansion: Of the chest at both pads (n + 1, 2), m.
        lost: 1 where a drive has not heard its command (n, 6).
    """

    lengths: np.ndarray
    force: np.ndarray
    expansion: np.ndarray
    lost: np.ndarray


def coloured(
    rng: np.random.Generator, shape: tuple[int, int], sigma: float, a: float
) -> np.ndarray:
    """Noise e_i = a e_(i-1) + white, of standard deviation sigma."""
    white = rng.standard_normal(shape)
    if a == 0.0:
        return sigma * white
    noise = np.empty(shape)
    noise[0] = white[0]
    part = np.sqrt(1.0 - a * a)
    for i in range(1, len(noise)):
        noise[i] = a * noise[i - 1] + part * white[i]
    return sigma * noise


def chest_expansion(
    rng: np.random.Generator, ticks: int, flaws: Flaws
) -> np.ndarray:
    """Expansion of the chest at both pads (ticks + 1, 2), m.

    A sin(phase) + its second harmonic; rate and depth wander slowly, and
    where a run starts in the breath is chance.
    """
    torso = flaws.torso
    if torso.breath == 0.0:
        return np.zeros((ticks + 1, 2))
    knots = np.arange(0.0, ticks * numbers.TICK + 4.0, 2.0)
    t = np.arange(ticks + 1) * numbers.TICK
    memory = float(np.exp(-2.0 / _WANDER_TIME))
    wander = coloured(rng, (len(knots), 2), _WANDER, memory)
    rate = torso.breath_rate * (1.0 + np.interp(t, knots, wander[:, 0]))
    depth = torso.breath * (1.0 + np.interp(t, knots, wander[:, 1]))
    start = rng.uniform(0.0, 2.0 * np.pi)
    phase = start + 2.0 * np.pi * numbers.TICK * np.cumsum(rate)
    wave = np.sin(phase) + torso.breath_second * np.sin(
        2.0 * phase + torso.breath_phase
    )
    sides = np.array([1.0 + torso.breath_sides, 1.0 - torso.breath_sides])
    return (depth * wave)[:, None] * sides


def lost_commands(
    rng: np.random.Generator, ticks: int, flaws: Flaws
) -> np.ndarray:
    """1 where a drive has not heard its command, (ticks, 6)."""
    lost = np.zeros((ticks, 6), dtype=np.uint8)
    if flaws.legs.hold_rate == 0.0:
        return lost
    starts = rng.random((ticks, 6)) < flaws.legs.hold_rate * numbers.TICK
    for tick, leg in np.argwhere(starts):
        ticks_held = rng.exponential(flaws.legs.hold_time) / numbers.TICK
        lost[tick : tick + 1 + int(ticks_held), leg] = 1
    return lost


def draw(
    rng: np.random.Generator, ticks: int, flaws: Flaws, noise: bool
) -> Chance:
    """All that is random in a run.

    Without noise the rest is drawn from the same generator in the same way,
    so that runs with and without it breathe alike.
    """
    breath_rng, lost_rng, noise_rng = rng.spawn(3)
    expansion = chest_expansion(breath_rng, ticks, flaws)
    lost = lost_commands(lost_rng, ticks, flaws)
    if not noise:
        zeros = np.zeros((ticks, 6)), np.zeros((ticks, 3))
        return Chance(*zeros, expansion, lost)
    colour = flaws.sensors.colour
    lengths = coloured(noise_rng, (ticks, 6), numbers.LENGTH_NOISE, colour)
    force = coloured(noise_rng, (ticks, 3), numbers.FORCE_NOISE, colour)
    return Chance(lengths, force, expansion, lost)

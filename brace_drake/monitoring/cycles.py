"""A motion that is repeated: home again and at rest after each time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.devices.motions.library import SafeMotion

# Rings go home in this time, s, and stand still so long: what is recorded from
# there on begins at rest.
HOME, REST = 1.5, 2.0


def close_cycle(motion: SafeMotion) -> SafeMotion:
    """A motion with the way home and a rest behind it.

    The way home is the polynomial of fifth degree from the last y, y', y'' to
    0, 0, 0.

    Args:
        motion: Sampled evenly.
    """
    step = motion.time[1] - motion.time[0]
    t = step * np.arange(1, round(HOME / step) + 1)
    home = np.apply_along_axis(_way_home, 0, motion.samples[-1], t)
    home = home.reshape(len(t), *motion.samples.shape[1:])
    rest = np.zeros((round(REST / step), *motion.samples.shape[1:]))
    samples = np.concatenate([motion.samples, home, rest])
    return replace(motion, time=step * np.arange(len(samples)), samples=samples)


def repeat_cycle(cycle: SafeMotion, count: int) -> SafeMotion:
    """A closed cycle so many times."""
    step = cycle.time[1] - cycle.time[0]
    samples = np.concatenate([cycle.samples] * count)
    return replace(cycle, time=step * np.arange(len(samples)), samples=samples)


def _way_home(start: np.ndarray, t: np.ndarray) -> np.ndarray:
    """y, y', y'' at times t (n, 3) from those at 0 (3,) to rest at `HOME`."""
    T = HOME
    y, v, a = start
    lowest = np.array([y, v, a / 2.0])
    # What the three highest powers have to make up for at T.
    ends = -np.array([y + v * T + a / 2.0 * T**2, v + a * T, a])
    powers = np.array(
        [
            [T**3, T**4, T**5],
            [3 * T**2, 4 * T**3, 5 * T**4],
            [6 * T, 12 * T**2, 20 * T**3],
        ]
    )
    way = np.polynomial.Polynomial([*lowest, *np.linalg.solve(powers, ends)])
    return np.column_stack([way(t), way.deriv(1)(t), way.deriv(2)(t)])

"""Parts of reference motions, each with its first two derivatives (N, 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

PEAK_SPEED = 1.875  # of a ramp, over its mean speed
# Of a multisine with a low crest.
_PHASES = np.array([0.0, 2.1, 4.4, 1.2, 5.3, 3.0])


def ramp(
    time: np.ndarray, start: float, duration: float, height: float
) -> np.ndarray:
    """From rest to rest: y = h (10 s^3 - 15 s^4 + 6 s^5), s = (t - t_0) / T.

    Args:
        time: (N,), s.
        start, duration: t_0 and T, s.
        height: h, m.

    Returns:
        y, m; y', m/s; y'', m/s^2 (N, 3).
    """
    s = np.clip((time - start) / duration, 0.0, 1.0)
    y = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    dy = 30.0 * s**2 * (1.0 - s) ** 2 / duration
    ddy = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / duration**2
    return height * np.column_stack([y, dy, ddy])


def steps(
    time: np.ndarray, heights: Sequence[float], hold: float, rise: float
) -> np.ndarray:
    """Ramps from one height to the next, m, each held for `hold` s (N, 3)."""
    out, before, start = np.zeros((len(time), 3)), 0.0, 0.5
    for height in heights:
        out += ramp(time, start, rise, height - before)
        before, start = height, start + rise + hold
    return out


def sines(
    time: np.ndarray,
    amplitudes: Sequence[float],
    rates: Sequence[float],
    phases: Sequence[float],
) -> np.ndarray:
    """y = sum of A_i sin(2 pi f_i t + p_i); m, Hz, rad (N, 3)."""
    a, w = np.asarray(amplitudes), 2.0 * np.pi * np.asarray(rates)
    angle = np.outer(time, w) + np.asarray(phases)
    s, c = np.sin(angle), np.cos(angle)
    return np.column_stack([s @ a, c @ (a * w), -s @ (a * w**2)])


def product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The product of two signals by the product rule (N, 3)."""
    (a, da, dda), (b, db, ddb) = first.T, second.T
    return np.column_stack(
        [a * b, da * b + a * db, dda * b + 2.0 * da * db + a * ddb]
    )


def growing_sine(
    time: np.ndarray, mean: float, amplitude: float, rate: float, rise: float
) -> np.ndarray:
    """A ramp to a mean, then a sine about it that grows to the end (N, 3).

    Args:
        time: (N,), s.
        mean, amplitude: Of the sine, m.
        rate: Hz.
        rise: Duration of the ramp, s.
    """
    grow = ramp(time, rise, max(time[-1] - rise, 1.0), 1.0)
    wave = sines(time, [amplitude], [rate], [-2.0 * np.pi * rate * rise])
    return ramp(time, 0.0, rise, mean) + product(grow, wave)


def multisine(time: np.ndarray, size: float, rates: np.ndarray) -> np.ndarray:
    """Six sines whose amplitudes fall as 1 / rate and add up to `size`, m."""
    amplitudes = 1.0 / rates
    return sines(time, amplitudes * size / amplitudes.sum(), rates, _PHASES)

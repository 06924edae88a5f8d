"""The ten motions of a campaign, each with its derivatives.

They load the same physics as the recordings of the bench: slow pushes, stairs,
reversals of growing amplitude, sums of sines, and holding still. Amplitudes,
speeds and phases vary from campaign to campaign.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.withheld.simulator.numbers import LOG_EVERY, TICK

DURATION = 12.0  # s
LOG_PERIOD = LOG_EVERY * TICK
_DECIMALS = 6  # of what is logged


@dataclass(frozen=True)
class Motion:
    """One run to make: file name, who wears it, what it asks for."""

    name: str
    contact: bool
    kind: str
    repeat_of: str | None
    split: str
    samples: np.ndarray  # y, y', y'' at 200 Hz, as logged (n, 3)
    wanted: np.ndarray  # the same at 1 kHz, as used (5 n, 3)


def between_samples(samples: np.ndarray) -> np.ndarray:
    """The reference at 1 kHz, of its log at 200 Hz, (5 n, 3).

    y and y' by cubic Hermite polynomials of the logged derivatives, y'' by
    straight lines.
    """
    s = (np.arange(LOG_EVERY) / LOG_EVERY)[:, None]
    before, after = samples, np.vstack([samples[1:], samples[-1:]])
    fine = np.empty((len(samples), LOG_EVERY, 3))
    for i in range(2):
        a, b = before[:, i], after[:, i]
        slope_a, slope_b = before[:, i + 1], after[:, i + 1]
        line = a + s * (b - a)
        bend = (1 - s) * (slope_a * LOG_PERIOD - (b - a))
        bend = bend - s * (slope_b * LOG_PERIOD - (b - a))
        fine[:, :, i] = (line + s * (1 - s) * bend).T
    fine[:, :, 2] = (before[:, 2] + s * (after[:, 2] - before[:, 2])).T
    return fine.reshape(-1, 3)


def ramp(t: np.ndarray, start: float, time: float, height: float) -> np.ndarray:
    """A cubic polynomial at rest at both ends, with derivatives (n, 3)."""
    s = np.clip((t - start) / time, 0.0, 1.0)
    inside = (t > start) & (t < start + time)
    y = height * s * s * (3.0 - 2.0 * s)
    v = height / time * 6.0 * s * (1.0 - s)
    a = np.where(inside, height / time**2 * (6.0 - 12.0 * s), 0.0)
    return np.column_stack([y, v, a])


def faded(t: np.ndarray, fade: np.ndarray, wave: np.ndarray) -> np.ndarray:
    """The product of two signals, each (n, 3) with its derivatives."""
    f, f1, f2 = fade.T
    y, v, a = wave.T
    return np.column_stack(
        [f * y, f1 * y + f * v, f2 * y + 2.0 * f1 * v + f * a]
    )


def sines(
    t: np.ndarray, amplitudes: np.ndarray, rates: np.ndarray, at: np.ndarray
) -> np.ndarray:
    """A sum of sines with derivatives, (n, 3); rates in Hz."""
    w = 2.0 * np.pi * rates
    angle = np.outer(t, w) + at
    return np.column_stack(
        [
            np.sin(angle) @ amplitudes,
            np.cos(angle) @ (amplitudes * w),
            -np.sin(angle) @ (amplitudes * w * w),
        ]
    )


def _on_grid(time):
    """A time moved to the next sample, so that no ramp starts between two."""
    return np.round(time / LOG_PERIOD) * LOG_PERIOD


def push(t, rng, height, time):
    """A cubic push to `height`, held to the end."""
    return ramp(t, _on_grid(rng.uniform(0.4, 0.8)), _on_grid(time), height)


def stairs(t, rng):
    """Steps up and down between 0 and about -9 mm."""
    heights = np.array([-2.0, -5.0, -9.0, -6.0, -2.0, -7.0]) * 1e-3
    heights = np.append(heights * rng.uniform(0.85, 1.05), 0.0)
    starts = _on_grid(0.5 + 1.9 * np.arange(6) + rng.uniform(0.0, 0.15, 6))
    wanted, before = np.zeros((len(t), 3)), 0.0
    for start, height in zip(starts, heights, strict=False):
        wanted += ramp(t, start, 0.4, height - before)
        before = height
    return wanted


def reversal(t, rng, mean, amplitude):
    """A slow sine whose amplitude grows, about a mean."""
    down = ramp(t, 0.0, 1.5, mean)
    grow = np.column_stack([t / DURATION, np.full_like(t, 1 / DURATION), 0 * t])
    fade = faded(t, ramp(t, 1.5, 0.5, amplitude), grow)
    rate = np.array([rng.uniform(0.22, 0.28)])
    phase = np.array([rng.uniform(0.0, 2.0 * np.pi)])
    return down + faded(t, fade, sines(t, np.ones(1), rate, phase))


def multisine(t, rng, mean, size):
    """Five sines of 0.2 to 3.7 Hz about a mean."""
    down = ramp(t, 0.0, 1.0, mean)
    rates = np.array([0.21, 0.51, 1.1, 1.9, 3.1]) * rng.uniform(0.85, 1.2, 5)
    amplitudes = size * np.array([1.0, 0.75, 0.47, 0.31, 0.19])
    phases = rng.uniform(0.0, 2.0 * np.pi, 5)
    wave = sines(t, amplitudes * rng.uniform(0.85, 1.15, 5), rates, phases)
    return down + faded(t, ramp(t, 1.0, 0.6, 1.0), wave)


def make_motions(rng: np.random.Generator) -> list[Motion]:
    """The ten motions of one campaign."""
    t = np.arange(round(DURATION / LOG_PERIOD)) * LOG_PERIOD
    height = -0.010 * rng.uniform(0.9, 1.05)
    pushed = push(t, rng, height, rng.uniform(5.5, 6.5))
    size = 1e-3 * rng.uniform(0.85, 1.1)
    mean = -5e-3 * rng.uniform(0.9, 1.1)
    table = (
        ("free_multisine", multisine(t, rng, 0.0, 2.2 * size)),
        ("free_reversal", reversal(t, rng, 0.0, 6e-3)),
        ("quiet_hold", np.zeros((len(t), 3))),
        ("push", pushed),
        ("push_repeat", pushed),
        ("stairs", stairs(t, rng)),
        ("reversal", reversal(t, rng, 0.8 * mean, 4e-3)),
        ("multisine", multisine(t, rng, mean, 0.9 * size)),
        ("validation_push", push(t, rng, 0.7 * height, rng.uniform(2.7, 3.5))),
        ("validation_multisine", multisine(t, rng, 1.2 * mean, 0.75 * size)),
    )
    return [_motion(name, wanted) for name, wanted in table]


def _motion(name: str, samples: np.ndarray) -> Motion:
    samples = np.round(samples, _DECIMALS) + 0.0
    kind = name.removeprefix("free_").removeprefix("validation_")
    return Motion(
        name=name,
        contact=not name.startswith("free"),
        kind=kind.removesuffix("_repeat"),
        repeat_of="push.csv" if name == "push_repeat" else None,
        split="validation" if name.startswith("validation") else "fit",
        samples=samples,
        wanted=between_samples(samples),
    )

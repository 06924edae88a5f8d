"""How what is left swings in time: where terms that do begin.

A search over a frequency finds its way only from nearer than one over a run's
length. So it begins at the peaks of what is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import find_peaks

from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import compare_runs

# How many peaks, and up to where, Hz.
_PEAKS, _HIGHEST_HZ = 6, 10.0
# Points of a spectrum for each of a run's own.
_FINER = 4


def residual_swings(
    evaluator: Evaluator, fit: CandidateFit
) -> tuple[float, ...]:
    """Frequencies of what a fit leaves, Hz, that of most power first.

    Channels count in units of their noise, runs alike.

    Args:
        evaluator: Over the fit runs.
        fit: The nominal fit, or one with effects.
    """
    named = fit if fit.effects else None
    grid = np.linspace(0.0, _HIGHEST_HZ, 2001)
    total = np.zeros(len(grid))
    for c in compare_runs(evaluator, fit, named):
        twin = c.before if named is None else c.after
        run = c.prepared
        scaled = (run.measured - twin)[:, run.used] / run.floor.rms[run.used]
        scaled -= scaled.mean(axis=0)
        rate = 1.0 / np.median(np.diff(run.run.time_s))
        size = _FINER * len(scaled)
        spectrum = np.abs(np.fft.rfft(scaled, size, axis=0)) ** 2
        power = spectrum.sum(axis=1) / len(scaled)
        total += np.interp(grid, np.fft.rfftfreq(size, 1.0 / rate), power)
    peaks, _ = find_peaks(total)
    best = peaks[np.argsort(-total[peaks])][:_PEAKS]
    return tuple(float(f) for f in grid[best] if f > 0.0)


def beginning_at(effect: Effect, swings: Sequence[float]) -> Effect:
    """A term whose frequency, where it has one, begins at others."""
    changed = tuple(
        replace(
            p, starts=tuple(f for f in swings if p.lower <= f <= p.upper)
            or p.starts,
        )
        if p.unit == "Hz"
        else p
        for p in effect.parameters
    )  # fmt: skip
    if changed == effect.parameters:
        return effect
    return replace(effect, parameters=changed)

"""Where terms that are periodic begin: at the peaks of what is left.

A search over a frequency finds its way only from nearer than one over the
length of a run, over a pitch from nearer than one over the travel. So it
begins at the peaks of a periodogram of the residual, over time or over place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from scipy.ndimage import median_filter

from brace_drake.devices.motions.reference import COLUMNS
from brace_drake.effects.card import Effect
from brace_drake.effects.unknown.places import WAY
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import compare_runs

# How many peaks of each, and up to where, Hz and 1/m.
_SWINGS, _HIGHEST_HZ = 6, 10.0
_RIPPLES, _WAVES = 4, np.arange(100.0, 4000.0, 10.0)
# Points of a spectrum in time for each of a run's own.
_FINER = 4
# Widths of a peak, one over the travel, that make the ground from which it
# rises; order of what of the residual goes slowly with place.
_GROUND, _SLOW = 4.0, 3
_COMMAND, _LENGTH = "_force_command_N", "_length_m"


@dataclass(frozen=True)
class Peaks:
    """Of what a fit leaves.

    Attributes:
        swings: Frequencies in time, Hz, that of most power first.
        of_legs: Pitches over the lengths of legs, m, the clearest first.
        of_ring: The same over the push of the ring.
    """

    swings: tuple[float, ...]
    of_legs: tuple[float, ...]
    of_ring: tuple[float, ...]


def residual_peaks(evaluator: Evaluator, fit: CandidateFit) -> Peaks:
    """Peaks of what a fit leaves on the fit runs.

    Args:
        evaluator: Over the fit runs.
        fit: The nominal fit, or one with effects.
    """
    named = fit if fit.effects else None
    compared = compare_runs(evaluator, fit, named)
    left = [
        (c.prepared, c.before if named is None else c.after) for c in compared
    ]
    names = evaluator.twin.channels
    legs = [n.removesuffix(_COMMAND) for n in names if n.endswith(_COMMAND)]
    over_legs, over_ring = np.zeros(len(_WAVES)), np.zeros(len(_WAVES))
    travel_of_legs, travel_of_ring = 0.0, 0.0
    for run, twin in left:
        push = run.run.channels.get(COLUMNS[0])
        for leg in legs:
            at, there = names.index(leg + _COMMAND), names.index(leg + _LENGTH)
            if not (run.used[at] and run.used[there]):
                continue
            error = (run.measured - twin)[:, at] / run.floor.rms[at]
            way = run.measured[:, there]
            over_legs += _power_over(way, error)
            travel_of_legs = max(travel_of_legs, np.ptp(way))
            if push is not None:
                over_ring += _power_over(push, error)
                travel_of_ring = max(travel_of_ring, np.ptp(push))
    return Peaks(
        _swings(left),
        _pitches(over_legs, travel_of_legs),
        _pitches(over_ring, travel_of_ring),
    )


def beginning_at(effect: Effect, peaks: Peaks) -> Effect:
    """A term whose frequency or pitch, where it has one, begins at peaks."""
    pitches = peaks.of_ring if "_ring_" in effect.name else peaks.of_legs
    found = {
        "frequency_Hz": peaks.swings,
        "pitch": tuple(p / WAY for p in pitches),
    }
    changed = tuple(
        _beginning(p, found.get(p.name, ())) for p in effect.parameters
    )
    if changed == effect.parameters:
        return effect
    return replace(effect, parameters=changed)


def _beginning(parameter, starts: Sequence[float]):
    low, high = parameter.lower, parameter.upper
    inside = tuple(s for s in starts if low <= s <= high)
    return replace(parameter, starts=inside) if inside else parameter


def _power_over(place: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Power of an error over waves of place, without what goes slowly."""
    usable = np.isfinite(error) & np.isfinite(place)
    q, e = place[usable], error[usable]
    if np.ptp(q) <= 0.0:
        return np.zeros(len(_WAVES))
    q = (q - q.mean()) / np.ptp(q)
    e = e - np.polyval(np.polyfit(q, e, _SLOW), q)
    waves = np.exp(-2j * np.pi * np.outer(_WAVES * np.ptp(place[usable]), q))
    return np.abs(waves @ e) ** 2 / len(e)


def _pitches(power: np.ndarray, travel: float) -> tuple[float, ...]:
    if not power.any():
        return ()
    ground = int(_GROUND / travel / np.diff(_WAVES)[0])
    clear = power / median_filter(power, ground, mode="nearest")
    peaks, _ = scipy.signal.find_peaks(clear)
    best = peaks[np.argsort(-clear[peaks])][:_RIPPLES]
    return tuple(float(1.0 / w) for w in _WAVES[best])


def _swings(left) -> tuple[float, ...]:
    """Of all channels in units of their noise; runs count alike."""
    grid = np.linspace(0.0, _HIGHEST_HZ, 2001)
    total = np.zeros(len(grid))
    for run, twin in left:
        scaled = (run.measured - twin)[:, run.used] / run.floor.rms[run.used]
        scaled -= scaled.mean(axis=0)
        rate = 1.0 / np.median(np.diff(run.run.time_s))
        size = _FINER * len(scaled)
        spectrum = np.abs(np.fft.rfft(scaled, size, axis=0)) ** 2
        power = spectrum.sum(axis=1) / len(scaled)
        total += np.interp(grid, np.fft.rfftfreq(size, 1.0 / rate), power)
    peaks, _ = scipy.signal.find_peaks(total)
    best = peaks[np.argsort(-total[peaks])][:_SWINGS]
    return tuple(float(f) for f in grid[best] if f > 0.0)

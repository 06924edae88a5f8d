"""A reading that is taken more rarely than it is recorded, and held between."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)
from brace_drake.recording_faults.channels import (
    is_computed,
    moves,
    noisy_channels,
)
from brace_drake.recording_faults.finding import Finding

# More than so many is two, of a reading's steps as of intervals. A reading that
# is coarse alone never moves by two steps at once and then stands: of those
# that are held, this share does each time.
_LEAP, _SHARE = 1.5, 0.5
# Fewer new values are no clock, and at shorter intervals hardly one is held.
_FEW, _SHORT = 20, 1.5
# New values come on time within so many samples: two clocks that are not one.
_ON_TIME = 1.01


def _undo(columns, channels, values):
    """Straight lines between the new values."""
    changed = {}
    for name in channels:
        x = columns[name]
        new = np.append(0, _new_values(x))
        changed[name] = np.interp(np.arange(len(x)), new, x[new])
    return with_columns(columns, changed)


CARD = RecordingFault(
    name="held_channel",
    title="sampled at a lower rate, and held",
    law="x_rec(t) = x(m T) from m T to (m + 1) T",
    signature="leaps by many steps at even intervals, and stands in between",
    remedy="record the channel at its own rate and write it on straight lines"
    " between its samples, or take the rate of the slowest channel for all",
    impostors={"force_lag": "a lag is smooth: it does not leap and stand"},
    parameters=(
        FaultParameter("interval_s", "s", "T, from one new value to the next"),
    ),
    undo=_undo,
    is_of_run=True,
)


def find_held(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """Readings of a run that are held, those of one interval together; a
    warning where nothing moves, so that they are late by nothing.
    """
    period = float(np.median(np.diff(run.time_s)))
    held: dict[float, dict[str, float]] = {}
    for name in noisy_channels(run, known):
        # What the controller computes may be computed rarely.
        if not is_computed(name):
            interval = interval_of(run.channels[name])
            if interval is not None:
                alike = held.setdefault(round(interval, 1), {})
                alike[name] = interval
    found = []
    for alike in held.values():
        names = tuple(alike)
        interval = float(np.mean(list(alike.values()))) * period
        found.append(
            Finding(
                CARD,
                (run.file,),
                names,
                {"interval_s": interval},
                detail=f"new values come at {1.0 / interval:.3g} Hz and stand"
                " in between",
                severity="error" if moves(run, known) else "warning",
                row=int(_new_values(run.channels[names[0]])[0]) + 1,
            )
        )
    return found


def interval_of(values: np.ndarray) -> float | None:
    """Samples from one new value of a held reading (N,) to the next; None of a
    reading that is not held.
    """
    new = _new_values(values)
    if len(new) < _FEW or len(new) * _SHORT > len(values):
        return None
    leaps = np.abs(np.diff(values))[new - 1] > _LEAP * quantum_of(values)
    gaps = np.diff(new)
    usual = gaps[gaps <= _LEAP * np.median(gaps)]
    # What comes twice alike is one gap of two.
    ticks = np.append(0, np.cumsum(np.round(gaps / np.mean(usual))))
    slope, start = np.polyfit(ticks, new, 1)
    late = np.abs(new - start - slope * ticks).max()
    if np.mean(leaps) < _SHARE or late > _ON_TIME or slope < _SHORT:
        return None
    return float(slope)


def _new_values(values: np.ndarray) -> np.ndarray:
    """Rows with another value than the row before."""
    return 1 + np.flatnonzero(np.diff(values) != 0.0)

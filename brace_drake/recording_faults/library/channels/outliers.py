"""Single samples that are far from their neighbours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)
from brace_drake.recording_faults.channels import noisy_channels
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.statistics import (
    largest_normal,
    local_error,
    robust_deviation,
)

# What is not normal in the noise of a sound reading, in deviations more.
_TAILS = 1.5
# Of a spike its neighbours know nothing: they differ by less than this part.
_ALONE = 0.5
# Samples in which other readings feel the same event.
_BY = 3
# A reading that shakes is rough around a sample: so many beside it tell how
# much, those next to it aside.
_BESIDE, _NEXT = 15, 2
# What spikes make of a channel's amplitude before they spoil a campaign, and so
# few of them never do.
_SPOILT, _FEW = 0.01, 3


def _undo(columns, channels, values):
    """Straight lines in place of the outliers."""
    changed, at = {}, None
    for name in channels:
        x = columns[name]
        at = np.arange(len(x)) if at is None else at
        good = ~outliers_of(x)
        changed[name] = np.interp(at, at[good], x[good])
    return with_columns(columns, changed)


CARD = RecordingFault(
    name="outliers",
    title="with outliers",
    law="x_rec = x + spikes in single samples",
    signature="samples many deviations from a cubic through their neighbours,"
    " which know nothing of it",
    remedy="find what disturbs the line; a few may be removed, an empty field"
    " in the table is filled",
    parameters=(FaultParameter("share", "1", "of the samples"),),
    undo=_undo,
    is_of_run=True,
)


def outliers_of(values: np.ndarray, number: int = 500_000) -> np.ndarray:
    """Marks of samples that are outliers (N,), bool.

    Args:
        values: Of one channel (N,).
        number: Samples of the campaign, for the rate of false alarms.
    """
    error, far = _far_off(values, number)
    clear = _TAILS * largest_normal(number)
    marks = np.zeros(len(values), dtype=bool)
    for i in np.flatnonzero(far):
        if abs(error[i]) <= clear * _roughness(error, i):
            continue
        near = values[max(0, i - 1)], values[min(len(values) - 1, i + 1)]
        # What a spike leaves of its own in the errors beside it is less.
        beside = np.abs(error[max(0, i - 1) : i + 2]).max()
        away = min(abs(values[i] - n) for n in near)
        alone = abs(near[1] - near[0]) < _ALONE * away
        # The peak of a triangle lies on the lines of both sides.
        alone &= _off_lines(values, i) > _ALONE * away
        # Where it turns round in a sample or two it is off both sides' lines.
        alone &= _turn(values, i) < _ALONE * away
        marks[i] = alone and abs(error[i]) >= beside
    return marks


def _far_off(values: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Errors beside neighbours, and which are no noise (N,) each."""
    error = local_error(values)
    noise = max(robust_deviation(error), 0.5 * quantum_of(values))
    far = np.abs(error) > _TAILS * largest_normal(number) * noise
    return error, far


def _felt(
    others: Sequence[tuple[np.ndarray, np.ndarray]], samples: int, number: int
) -> np.ndarray:
    """Samples in which others of a run leave their course as well, spikes of
    their own aside: that is an event (N,), bool.

    Args:
        others: Readings, and marks of their outliers.
        samples, number: N, and as of `outliers_of`.
    """
    found, at = np.zeros(samples, dtype=bool), np.arange(samples)
    for values, marks in others:
        without = np.interp(at, at[~marks], values[~marks])
        found |= _far_off(without, number)[1]
    return maximum_filter1d(found, _BY)


def _turn(values: np.ndarray, i: int) -> float:
    """By how much steps behind a sample differ from those before it."""
    before, after = values[max(0, i - 3) : i], values[i + 1 : i + 4]
    if len(before) < 2 or len(after) < 2:
        return 0.0
    return abs(float(np.mean(np.diff(after)) - np.mean(np.diff(before))))


def _off_lines(values: np.ndarray, i: int) -> float:
    """How far a sample is from the nearer one of the lines through the two
    samples before it and the two behind it; inf where there is none.
    """
    off = [np.inf]
    if i >= 2:
        off.append(abs(values[i] - 2.0 * values[i - 1] + values[i - 2]))
    if i + 2 < len(values):
        off.append(abs(values[i] - 2.0 * values[i + 1] + values[i + 2]))
    return float(min(off))


def _roughness(error: np.ndarray, i: int) -> float:
    """Standard deviation of the errors around a sample, without its own."""
    before = error[max(0, i - _BESIDE) : max(0, i - _NEXT)]
    after = error[i + _NEXT + 1 : i + _BESIDE + 1]
    return robust_deviation(np.concatenate([before, after]))


def _spoils(values: np.ndarray, marks: np.ndarray) -> bool:
    """Whether spikes make a part of a channel that counts."""
    size = np.linalg.norm(local_error(values)[marks])
    whole = np.linalg.norm(values - values.mean())
    return bool(marks.sum() > _FEW and size > _SPOILT * whole)


def find_outliers(
    run: Run, known: Mapping[str, Channel], number: int
) -> list[Finding]:
    """Channels of a run with outliers."""
    found = []
    names = noisy_channels(run, known)
    marked = {n: outliers_of(run.channels[n], number) for n in names}
    for name, marks in marked.items():
        if marks.any():
            others = [(run.channels[n], marked[n]) for n in names if n != name]
            marks = marks & ~_felt(others, len(marks), number)
        count = int(marks.sum())
        if not count:
            continue
        spoils = _spoils(run.channels[name], marks)
        row = int(np.argmax(marks)) + 1
        detail = f"{count} of its samples stand out from their neighbours"
        found.append(
            Finding(
                CARD,
                (run.file,),
                (name,),
                {"share": count / len(marks)},
                detail=detail,
                row=row,
                severity="error" if spoils else "warning",
            )
        )
    return found

"""A reading that is cut off at a level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import (
    noisy_channels,
    references,
)
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.statistics import (
    noise_deviation,
    stretches,
)

CARD = RecordingFault(
    name="clipped_channel",
    title="cut off at a level",
    law="x_rec = min(x, upper), or max(x, lower)",
    signature="many samples exactly at the greatest or least value, few just"
    " below: noise would have spread them",
    remedy="check the range of the recorder; record the run again",
    impostors={"saturation": "cuts off what a drive does, not what is written"},
    parameters=(
        FaultParameter("level", "of the channel", "where it is cut off"),
        FaultParameter("share", "1", "of the samples at the level"),
    ),
    is_of_run=True,
)
_LEAST = 20
# A reading that is at its greatest value where it turns repeats itself in so
# many samples before and after, so often.
_BESIDE, _OFTEN = 8, 0.3
# Samples at the level over those within this many deviations below.
_PILED, _BAND = 3.0, 3.0
# A channel moves where it changes by such a part of its range.
_ASKED = 0.1


def find_clipped(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """Readings of a run that are cut off at either end."""
    found = []
    ways = [n for n, c in known.items() if c.is_way and n in run.channels]
    for name in dict.fromkeys((*noisy_channels(run, known), *ways)):
        values = run.channels[name]
        if name in ways and not _has_noise(values):
            # It may stand where it was asked to.
            continue
        if known[name].saturates == "command":
            # A controller cuts off its own commands.
            continue
        if np.ptp(values) == 0.0:
            continue
        moving = _beside(run, known, name)
        for sign in (1.0, -1.0):
            share = _share_at_top(sign * values, moving)
            if share is None:
                continue
            level = float(sign * np.max(sign * values))
            row = int(np.argmax(values == level)) + 1
            detail = f"{share * 100:.3g} % of its samples are exactly {level:g}"
            found.append(
                Finding(
                    CARD,
                    (run.file,),
                    (name,),
                    {"level": level, "share": share},
                    detail=detail,
                    row=row,
                )
            )
    return found


def _share_at_top(
    values: np.ndarray, moving: Sequence[np.ndarray]
) -> float | None:
    """Share of samples at the greatest value, None where noise or rest made it.

    A noisy reading that comes to rest scatters around its last value, so that
    its greatest is rare among the samples just below. One of steps coarser
    than its noise rests without that: see `_rests`.
    """
    top = values.max()
    at_top = int(np.count_nonzero(values == top))
    if at_top < _LEAST:
        return None
    step = quantum_of(values)
    noise = noise_deviation(values)
    if _rests_beside(values, top):
        return None
    band = _BAND * max(noise, step) + step
    below = np.count_nonzero((values < top) & (values > top - band))
    if at_top <= _PILED * below:
        return None
    if noise < step and _rests(values, top, moving):
        return None
    return at_top / len(values)


def _has_noise(values: np.ndarray) -> bool:
    """Whether a reading that stands still would not repeat itself."""
    step = quantum_of(values)
    return 0.0 < step <= noise_deviation(values)


def _beside(
    run: Run, known: Mapping[str, Channel], name: str
) -> list[np.ndarray]:
    """What a run is asked to move beside a channel; its other readings where
    that is nothing.
    """
    for names in (references(run, known), noisy_channels(run, known)):
        others = [run.channels[n] for n in names if n != name]
        if others:
            return others
    return []


def _rests(
    values: np.ndarray, top: float, moving: Sequence[np.ndarray]
) -> bool:
    """Whether a reading rests at its greatest value as at others between its
    ends, or at zero, or where nothing beside it moves.
    """
    if top == 0.0:
        return True
    edges = np.flatnonzero(np.diff(values) != 0.0)
    begins, ends = np.append(0, edges + 1), np.append(edges + 1, len(values))
    long = ends - begins >= _LEAST
    between = (values[begins] < top) & (values[begins] > values.min())
    if np.any(long & between):
        return True
    asked = [
        float(np.ptp(x[b:e])) > _ASKED * float(np.ptp(x))
        for x in moving
        for b, e in zip(begins[long], ends[long], strict=True)
    ]
    return bool(moving) and not any(asked)


def _rests_beside(values: np.ndarray, top: float) -> bool:
    """Whether a reading also repeats itself before and after it is at the top,
    as one without noise does where it turns.
    """
    alike = np.diff(values) == 0.0
    beside = []
    for begin, end in stretches(values == top):
        beside += [*alike[max(0, begin - _BESIDE) : max(0, begin - 1)]]
        beside += [*alike[end : end + _BESIDE - 1]]
    return bool(beside) and float(np.mean(beside)) > _OFTEN

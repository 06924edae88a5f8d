"""A reading whose zero is set anew while it is recorded."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.recording.columns import Channel, split_unit
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)
from brace_drake.recording_faults.channels import noisy_channels, references
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.statistics import noise_deviation, usual_step


def _undo(columns, channels, values):
    time = columns["time_s"]
    after = time - time[0] >= values["start_s"]
    return with_columns(
        columns, {c: columns[c] - values["offset"] * after for c in channels}
    )


CARD = RecordingFault(
    name="zero_step",
    title="recorded with a zero that leaps in mid-run",
    law="x_rec = x + offset from t_0 on",
    signature="one step between samples is many times all others, and stays;"
    " other positions know nothing of it",
    remedy="do not set a zero while a run is recorded; unwrap an angle; or"
    " subtract the offset from there on",
    parameters=(
        FaultParameter("offset", "of the channel", "of the leap"),
        FaultParameter("start_s", "s", "t_0, from the first sample"),
    ),
    undo=_undo,
    is_of_run=True,
)
_POSITIONS = ("m", "rad")
# A leap is so many times the next largest step, and so many deviations of the
# reading's noise.
_LARGER, _CLEAR = 5.0, 20.0
# Samples before and after it that it shifts, and by how much of it.
_BESIDE, _STAYS = 10, 0.7
_LEAST = 50
# Another position knows of it from so many times its usual steps on.
_UNUSUAL = 2.0


def likeliest_step(values: np.ndarray) -> tuple[int, float]:
    """Sample (of N) from which on values have another mean, and by how much, as
    least squares have it.
    """
    count = len(values)
    after = np.arange(1, count)
    sums = np.cumsum(values - values.mean())[:-1]
    # Before it n values of the mean a, behind it N - n of b.
    gained = sums**2 * count / (after * (count - after))
    at = int(np.argmax(gained)) + 1
    return at, float(np.mean(values[at:]) - np.mean(values[:at]))


def find_zero_steps(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """Positions of a run that leap once while another does not."""
    if len(run.time_s) < _LEAST:
        return []
    read = _positions(noisy_channels(run, known))
    given = _positions(references(run, known))
    leaps = {n: at for n in read if (at := _leap(run.channels[n])) is not None}
    found = []
    for name, at in leaps.items():
        others = [n for n in {*read, *given} - {name} if _moves(run, n)]
        knowing = [n for n in others if _leaps_at(run, n, at)]
        # Of lost samples the reference knows, and most of what is read.
        is_lost = not {*given}.isdisjoint(knowing)
        if not is_lost and len(others) > 2 * len(knowing):
            found.append(_finding(run, name, at))
    return found


def _moves(run: Run, name: str) -> bool:
    return float(np.ptp(run.channels[name])) > 0.0


def _positions(names) -> list[str]:
    return [n for n in names if split_unit(n)[1] in _POSITIONS]


def _leap(values: np.ndarray) -> int | None:
    """Sample before the one step that is many times all others."""
    steps = np.abs(np.diff(values))
    at = int(np.argmax(steps))
    others = float(np.max(np.delete(steps, at), initial=0.0))
    noise = noise_deviation(np.delete(values, [at, at + 1]))
    if steps[at] <= max(_LARGER * others, _CLEAR * noise):
        return None
    before = values[max(0, at + 1 - _BESIDE) : at + 1]
    after = values[at + 1 : at + 1 + _BESIDE]
    stays = abs(float(np.median(after)) - float(np.median(before)))
    return at if stays >= _STAYS * steps[at] else None


def _leaps_at(run: Run, name: str, at: int) -> bool:
    """Whether a channel does not go on there as it does elsewhere; a little
    before or after will do, as of a step and its answer.
    """
    steps = np.abs(np.diff(run.channels[name]))
    near = steps[max(0, at - _BESIDE) : at + _BESIDE + 1]
    return bool(np.max(near) > _UNUSUAL * usual_step(steps))


def _finding(run: Run, name: str, at: int) -> Finding:
    values = run.channels[name]
    offset = float(values[at + 1] - values[at])
    start = float(run.time_s[at + 1] - run.time_s[0])
    detail = f"it leaps by {offset:.4g} at {start:.4g} s, for good"
    parameters = {"offset": offset, "start_s": start}
    return Finding(
        CARD, (run.file,), (name,), parameters, detail=detail, row=at + 2
    )

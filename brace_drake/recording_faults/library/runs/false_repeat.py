"""A run that does not repeat the one it is said to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from posixpath import normpath

import numpy as np

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import noisy_channels, references
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.runs import exchanged_runs
from brace_drake.recording_faults.statistics import noise_deviation

CARD = RecordingFault(
    name="false_repeat",
    title="no repeat of the run that it names",
    law="repeat_of names a run with other inputs",
    signature="the two references differ",
    remedy="correct repeat_of, or the files that are exchanged; until then"
    " their difference is no noise",
    parameters=(
        FaultParameter("difference", "1", "of the references, of their range"),
    ),
    is_of_run=True,
)
# Share of the range by which two references may be off.
_GROSS = 0.01
# Readings clearly above their noise repeat no other that is so far off, in
# parts of their deviation.
_CLEAR, _APART = 10.0, 0.25


def same_inputs(a: Run, b: Run, names: Sequence[str]) -> float:
    """Greatest difference of two runs' inputs beyond a step of their readings,
    in parts of their range.
    """
    largest = 0.0
    for name in names:
        x, y = a.channels[name], b.channels.get(name)
        if y is None:
            continue
        rows = min(len(x), len(y))
        step = quantum_of(x)
        extent = max(np.ptp(x), np.ptp(y), 10.0 * step, 1e-9)
        apart = float(np.abs(x[:rows] - y[:rows]).max())
        largest = max(largest, (apart - step) / extent)
    return largest


def find_false_repeats(
    runs: Sequence[Run], known: Mapping[str, Channel]
) -> list[Finding]:
    """Runs with repeat_of whose inputs, or torso, are another run's."""
    by_file = {normpath(r.file): r for r in runs}
    found = []
    for run in runs:
        original = by_file.get(normpath(run.repeat_of or ""))
        if run.repeat_of is None or original is None or original is run:
            continue
        names = references(run, known)
        difference = same_inputs(run, original, names)
        if difference <= _GROSS and run.contact == original.contact:
            found += _of_answer(run, original, known)
            continue
        exchanged = _exchanged(run, original, runs, names)
        seen = (
            f"its reference is up to {100 * difference:.3g} % of the range off"
        )
        if run.contact != original.contact:
            seen = "one has the torso, the other not"
        if exchanged is not None:
            moved, place = exchanged
            seen += f", and that of {place.file} is what it should be"
            found.append(
                Finding(
                    exchanged_runs.CARD,
                    (moved.file, place.file),
                    detail=f"{run.file} repeats {original.file}, but {seen}",
                    probability=0.95,
                )
            )
        found.append(
            Finding(
                CARD,
                (run.file,),
                (),
                {"difference": difference},
                detail=f"repeat_of {original.file}, but {seen}",
            )
        )
    return found


def _of_answer(
    run: Run, original: Run, known: Mapping[str, Channel]
) -> list[Finding]:
    """A warning where a run with the same inputs is answered by readings that
    are all far from the original's: that is no noise either.
    """
    given = references(run, known)
    apart = []
    for name in noisy_channels(run, known):
        if name in given or "command" in name or name not in original.channels:
            continue
        x, y = run.channels[name], original.channels[name]
        rows = min(len(x), len(y))
        noise = noise_deviation(x)
        if rows and np.std(x) > _CLEAR * noise:
            off = float(np.sqrt(np.mean((x[:rows] - y[:rows]) ** 2)))
            apart.append((off / float(np.std(x)), name))
    least = min(apart, default=(0.0, ""))
    if least[0] < _APART:
        return []
    return [
        Finding(
            CARD,
            (run.file,),
            (),
            {"difference": least[0]},
            probability=0.8,
            detail=f"repeat_of {original.file}, but {least[1]} is"
            f" {100 * least[0]:.3g} % of its own deviation off that",
            severity="warning",
        )
    ]


def _exchanged(
    run: Run, original: Run, runs: Sequence[Run], names: Sequence[str]
) -> tuple[Run, Run] | None:
    """Which of a false pair stands in another's place, and in whose.

    Where a third run has the inputs of one of the two, that third is what the
    other should be.
    """
    for stays, moved in ((run, original), (original, run)):
        for third in runs:
            if not names or third in (run, original):
                continue
            if third.contact != stays.contact or third.repeat_of:
                continue
            if same_inputs(stays, third, names) <= _GROSS:
                return moved, third
    return None

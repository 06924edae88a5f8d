"""A block of samples that is there twice."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import noisy_channels
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.statistics import stretches

CARD = RecordingFault(
    name="repeated_samples",
    title="a block of samples twice",
    law="rec(n + m) = rec(n) for a block of n",
    signature="rows that are alike to the last digit of every noisy channel",
    remedy="check how the recorder hands over its buffers; record again",
    parameters=(
        FaultParameter("start_s", "s", "where the second copy begins"),
        FaultParameter("samples", "1", "rows that were there before"),
    ),
    is_of_run=True,
)
# Noisy channels that tell two rows apart, and rows in a block.
_CHANNELS, _LEAST = 4, 2


def find_repeated(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """Blocks of rows of a run that it holds twice."""
    names = [
        n for n in noisy_channels(run, known) if np.ptp(run.channels[n]) > 0.0
    ]
    if len(names) < _CHANNELS:
        return []
    marks = _seen_before(run.stack(names))
    found = [(a, b) for a, b in stretches(marks) if b - a >= _LEAST]
    if not found:
        return []
    begin, _ = max(found, key=lambda s: s[1] - s[0])
    samples = sum(b - a for a, b in found)
    start = float(run.time_s[begin] - run.time_s[0])
    detail = (
        f"{samples} rows were there before, the longest block at {start:.4g} s"
    )
    return [
        Finding(
            CARD,
            (run.file,),
            (),
            {"start_s": start, "samples": float(samples)},
            detail=detail,
            row=begin + 1,
        )
    ]


def _seen_before(rows: np.ndarray) -> np.ndarray:
    """Marks of rows that equal an earlier one (N,), bool."""
    _, first, inverse = np.unique(
        rows, axis=0, return_index=True, return_inverse=True
    )
    return first[inverse.ravel()] < np.arange(len(rows))

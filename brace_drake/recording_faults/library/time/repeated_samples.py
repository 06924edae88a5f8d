"""A block of samples that is there twice."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.identification.noise_floor import quantum_of
from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.channels import is_computed, noisy_channels
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.time.lost_samples import jumps_of
from brace_drake.recording_faults.statistics import (
    noise_deviation,
    unlikely_blocks,
)

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
# Noisy channels that tell two rows apart.
_CHANNELS = 4
# Steps of noise after which a reading is not the same again.
_MANY = 10.0


def find_repeated(run: Run, known: Mapping[str, Channel]) -> list[Finding]:
    """Blocks of rows of a run that it holds twice."""
    names = [
        n for n in noisy_channels(run, known) if np.ptp(run.channels[n]) > 0.0
    ]
    if not names:
        return []
    may_return = len(names) < _CHANNELS and not any(
        _shakes(n, run.channels[n]) for n in names
    )
    if len(names) < _CHANNELS:
        # What is put in tells rows apart as well.
        names = [n for n, x in run.channels.items() if np.ptp(x) > 0.0]
        names.remove("time_s")
    found = _copied_blocks(run.stack(names))
    if may_return:
        # A motion that comes round again does not jump to do so.
        rows = [jumps_of(run.channels[n]) for n in names]
        begins = set(np.concatenate(rows).tolist())
        found = [b for b in found if b[0] - 1 in begins]
    if not found:
        return []
    samples = sum(b - a for a, b in found)
    begin, _ = max(found, key=lambda s: s[1] - s[0])
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


def _shakes(name: str, values: np.ndarray) -> bool:
    """Whether a sensor has noise of many steps, which does not come again."""
    if is_computed(name):
        return False
    noise = noise_deviation(values)
    return noise > _MANY * quantum_of(values)


def _copied_blocks(rows: np.ndarray) -> list[tuple[int, int]]:
    """Begin and end of blocks of rows (N, C) that equal earlier ones."""
    lags = _lags(rows)
    return [
        (begin, end)
        for begin, end in unlikely_blocks(lags)
        if end - begin <= lags[begin]
    ]


def _lags(rows: np.ndarray) -> np.ndarray:
    """How far before each row the nearest equal one is; 0 without (N,)."""
    _, inverse = np.unique(rows, axis=0, return_inverse=True)
    order = np.argsort(inverse.ravel(), kind="stable")
    same = np.diff(inverse.ravel()[order]) == 0
    lags = np.zeros(len(rows), dtype=int)
    lags[order[1:][same]] = np.diff(order)[same]
    return lags

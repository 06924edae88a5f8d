"""Runs whose samples leave a gap in time."""

from __future__ import annotations

import itertools

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.recording.importing.rules import rows_at
from brace_drake.recording.read import LEAST_ROWS
from brace_drake.recording.table import Columns

# A step in time of so many usual ones is a gap: no motion is known in it.
_GAP = 5.0
# Parts that last less tell nothing, s.
_LEAST_S = 1.0

SPLIT, REFUSE = "split", "refuse"


def without_gaps(
    source, columns: Columns, gaps: str, rate: float | None
) -> list[Columns]:
    """A file's channels in parts without a gap, each with its time from 0.

    Args:
        source: The file, for messages.
        columns: Its channels.
        gaps: SPLIT, or REFUSE.
        rate: At which it will be resampled, Hz; None: as it is.

    Raises:
        CampaignError: There is a gap, and it is not to be split, or no part
            lasts a second and has as many rows as a run needs.
    """
    time = columns["time_s"]
    steps = np.diff(time)
    usual = max(float(np.median(steps)), 1.0 / rate if rate else 0.0)
    ends = np.flatnonzero(steps > _GAP * usual) + 1
    if not len(ends):
        return [columns]
    if gaps != SPLIT:
        row = int(ends[0])
        raise CampaignError(
            f"{source}: row {row + 1}: the time jumps by"
            f" {steps[row - 1]:.3g} s, one of {len(ends)} such gaps; say"
            f" `gaps: {SPLIT}` to make a run of each part"
        )
    bounds = [0, *map(int, ends), len(time)]
    parts = [
        {name: values[a:b] for name, values in columns.items()}
        for a, b in itertools.pairwise(bounds)
        if _is_enough(time[a:b], rate)
    ]
    if not parts:
        raise CampaignError(
            f"{source}: gaps leave no part of {_LEAST_S:g} s and"
            f" {LEAST_ROWS} rows or more"
        )
    return [{**p, "time_s": p["time_s"] - p["time_s"][0]} for p in parts]


def _is_enough(time: np.ndarray, rate: float | None) -> bool:
    """Whether a part's samples tell anything, at the rate it will have."""
    duration = float(time[-1] - time[0])
    rows = min(len(time), rows_at(rate, duration) if rate else len(time))
    return duration >= _LEAST_S and rows >= LEAST_ROWS

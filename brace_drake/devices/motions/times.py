"""How long and how finely sampled a reference may be."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.recording.findings import counted
from brace_drake.recording.read import LEAST_ROWS
from brace_drake.recording.recording import Run

# Deviation of a step from the mean one, relative.
EVEN = 1e-3
# No controller ticks much faster. What is longer, or has more samples, is no
# motion of a brace, and its diagram needs gigabytes: 2 MB for each second at
# 200 Hz, and 8 MB of a whole brace with noise.
LEAST_STEP_S, LONGEST_S, MOST_ROWS = 1e-4, 600.0, 120_000


def check_times(path: Path, time: np.ndarray) -> None:
    """Refuses times of a reference's file that no brace can be moved by.

    Args:
        path: Of the file, for the message.
        time: (N,), s, finite.

    Raises:
        CampaignError: One line: the file, the value, what is allowed.
    """
    if len(time) > MOST_ROWS:
        raise CampaignError(
            f"{path}: {len(time)} rows; allowed: {MOST_ROWS} or fewer"
        )
    # Of times that do not increase as well.
    lasts = float(time.max()) - float(time.min())
    if not lasts <= LONGEST_S:
        raise CampaignError(
            f"{path}: time_s lasts {lasts:g} s; allowed: {LONGEST_S:g} s or"
            " less"
        )
    steps = np.diff(time)
    if len(time) < 2 or not steps.min() > 0.0:
        raise CampaignError(f"{path}: time_s does not increase strictly")
    if np.abs(steps / steps.mean() - 1.0).max() > EVEN:
        raise CampaignError(f"{path}: time_s is not evenly sampled")
    # Steps of a clock that has counted since 1970 are rounded.
    if steps.mean() < LEAST_STEP_S * (1.0 - EVEN):
        raise CampaignError(
            f"{path}: time_s goes on by {steps.mean():g} s; allowed:"
            f" {LEAST_STEP_S:g} s or more"
        )


def check_recorded_rows(run: Run, period: float) -> None:
    """Refuses a motion that is over before a recording of it can be used.

    Args:
        run: With its times.
        period: Of the recording, s.

    Raises:
        CampaignError: One line.
    """
    lasts = float(run.time_s[-1] - run.time_s[0])
    # A last sample that rounding puts behind the end is among them.
    rows = int(lasts / period + 1e-6) + 1
    if rows < LEAST_ROWS:
        least = (LEAST_ROWS - 1) * period
        raise CampaignError(
            f"{run.file}: time_s lasts {lasts:g} s, which is"
            f" {counted(rows, 'row')} at {1.0 / period:g} Hz; allowed:"
            f" {LEAST_ROWS} rows or more, {least:g} s"
        )

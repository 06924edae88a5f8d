"""Does a run that is said to be free of the torso press on nothing?"""

from __future__ import annotations

import numpy as np

from brace_drake.recording.columns import BENCH, BRACE
from brace_drake.recording.findings import warning
from brace_drake.recording.recording import Problem
from brace_drake.recording.signs import smoothed
from brace_drake.recording.table import Columns

# No sensor drifts so far in a run, N; a brace presses with more.
_PRESSES = 3.0


def check_free(
    device: str | None, columns: Columns, rate_hz: float, file: str
) -> list[Problem]:
    """Warns about a run without contact whose force changes as if in contact.

    Args:
        device: A key of DEVICES.
        columns: All its channels, finite, each of shape (N,).
        rate_hz: Sampling rate.
        file: The recording's name.
    """
    if device not in (BENCH, BRACE):
        return []
    found = []
    for name, values in columns.items():
        if "_force_" not in name or name.startswith("leg"):
            continue
        change = float(np.ptp(smoothed(values, rate_hz)))
        if change > _PRESSES:
            message = (
                f"changes by {change:.1f} N in a run with contact: false; was"
                " the torso there?"
            )
            found.append(warning(file, message, name))
    return found

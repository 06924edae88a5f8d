"""Channels that are written later, or earlier, than the others."""

import numpy as np

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)


def shifted(values: np.ndarray, samples: float) -> np.ndarray:
    """x(n + samples) by straight lines, the ends held (N,)."""
    at = np.arange(len(values), dtype=float)
    return np.interp(at + samples, at, values)


def _undo(columns, channels, values):
    period = float(np.median(np.diff(columns["time_s"])))
    late = values["delay_s"] / period
    return with_columns(
        columns, {c: shifted(columns[c], late) for c in channels}
    )


CARD = RecordingFault(
    name="skewed_channel",
    title="recorded with a delay",
    law="x_rec(t) = x(t - delay)",
    signature="commands follow from readings once the channels are moved in"
    " time",
    remedy="give all channels one clock, or move the columns by the delay",
    impostors={
        "command_delay": "acts behind the command that is recorded",
        "force_lag": "the controller reads it too",
    },
    parameters=(
        FaultParameter("delay_s", "s", "of the channels against the others"),
    ),
    undo=_undo,
)

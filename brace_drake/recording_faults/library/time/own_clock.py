"""Channels whose recorder has a clock of its own, fast or slow."""

import numpy as np

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)


def _undo(columns, channels, values):
    time = columns["time_s"] - columns["time_s"][0]
    at = time / (1.0 + values["rate"])
    # Of a slow clock the end was not recorded.
    rows = at <= time[-1]
    found = {name: column[rows] for name, column in columns.items()}
    own = {c: np.interp(at[rows], time, columns[c]) for c in channels}
    return with_columns(found, own)


CARD = RecordingFault(
    name="own_clock",
    title="recorded by a clock of another rate",
    law="x_rec(t) = x((1 + rate) t)",
    signature="the channels run ahead of the others, or behind them, by a delay"
    " that grows from nothing",
    remedy="record all channels by one clock, or stretch the columns in time",
    parameters=(
        FaultParameter(
            "rate", "1", "by which the channels run ahead of the others"
        ),
    ),
    undo=_undo,
)

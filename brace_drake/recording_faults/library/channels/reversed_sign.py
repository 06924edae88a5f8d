"""A channel with the wrong sign."""

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)


def _undo(columns, channels, values):
    zero = values.get("zero", 0.0)
    return with_columns(columns, {c: 2.0 * zero - columns[c] for c in channels})


CARD = RecordingFault(
    name="reversed_sign",
    title="recorded with the wrong sign",
    law="x_rec - zero = -(x - zero)",
    signature="the channel moves against what commands and readings ask for",
    remedy="turn the sign of the column",
    impostors={"force_gain": "changes what is done, not what is written"},
    parameters=(
        FaultParameter("zero", "of the channel", "value that stays the same"),
    ),
    undo=_undo,
)

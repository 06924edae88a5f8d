"""A channel with a constant added where it is written, not where it is read."""

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)


def _undo(columns, channels, values):
    return with_columns(
        columns, {c: columns[c] - values["offset"] for c in channels}
    )


CARD = RecordingFault(
    name="moved_zero",
    title="recorded with a moved zero",
    law="x_rec = x + offset",
    signature="the recorded commands follow from the readings once a constant"
    " is taken off the channel",
    remedy="subtract the offset from the column; where all legs have it and the"
    " machine is not the scenario's, name its own scenario",
    impostors={
        "force_bias": "the controller reads it too",
        "encoder_offset": "the controller reads it too",
    },
    parameters=(
        FaultParameter("offset", "of the channel", "recorded less true"),
    ),
    undo=_undo,
)

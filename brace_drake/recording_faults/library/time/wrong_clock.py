"""Sample times of a clock that runs fast or slow."""

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)


def _undo(columns, channels, values):
    time = columns["time_s"]
    stretched = time[0] + (time - time[0]) * values["rate_ratio"]
    return with_columns(columns, {"time_s": stretched})


CARD = RecordingFault(
    name="wrong_clock",
    title="sample times of a wrong clock",
    law="t_rec = t / rate_ratio",
    signature="slopes of the reference are off its recorded velocity, and those"
    " of the velocity off the acceleration, by the same factor",
    remedy="write the true rate into rate_hz and time_s",
    parameters=(
        FaultParameter("rate_ratio", "1", "true over recorded time steps"),
        FaultParameter("true_rate_hz", "Hz", "at which it was sampled"),
    ),
    undo=_undo,
)

"""Blocks of samples that are not there, under times that go on evenly."""

from brace_drake.recording_faults.card import FaultParameter, RecordingFault

CARD = RecordingFault(
    name="lost_samples",
    title="lost blocks of samples",
    law="rec(n) = x(n + m) from a sample on",
    signature="the reference jumps by more than its recorded velocity allows",
    remedy="record again, or write the true time_s: gaps of up to five samples"
    " are filled",
    parameters=(
        FaultParameter("start_s", "s", "time of the first jump"),
        FaultParameter("lost_s", "s", "time that is missing there"),
        FaultParameter("jumps", "1", "number of jumps"),
    ),
    is_of_run=True,
)

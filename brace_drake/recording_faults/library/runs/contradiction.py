"""Channels that contradict each other, by no fault that has a name."""

from brace_drake.recording_faults.card import RecordingFault

CARD = RecordingFault(
    name="contradiction",
    title="in contradiction to the rest",
    law="none",
    signature="recorded channels do not follow from each other by a law that"
    " holds whatever the machine does",
    remedy="check columns, units and clocks, and that the scenario's controller"
    " is the one that ran",
)

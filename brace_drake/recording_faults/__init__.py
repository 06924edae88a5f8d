"""Faults of the recording: what a campaign's files can have wrong themselves.

A recording fault is a card, as an effect is: its law says what the recorder has
made of the truth, and `undo` takes that back. What the files alone, or the
declared control law, contradict is found before any fit (`check`). What is
seen only against the fitted twin competes with the effects (`against_twin`).
"""

from brace_drake.recording_faults.check import check_recording
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.registry import all_recording_faults

__all__ = ["Finding", "all_recording_faults", "check_recording"]

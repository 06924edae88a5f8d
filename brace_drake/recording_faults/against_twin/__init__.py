"""Faults that only the fitted twin shows, beside the effects that compete."""

from brace_drake.recording_faults.against_twin.judge import (
    find_recording_faults,
    judge_campaign,
)
from brace_drake.recording_faults.against_twin.odd_runs import Maker

__all__ = ["Maker", "find_recording_faults", "judge_campaign"]

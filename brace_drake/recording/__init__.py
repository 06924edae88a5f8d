"""Campaigns: folders of recordings, read, checked and written."""

from brace_drake.recording.check import CheckCampaign
from brace_drake.recording.columns import DEVICES, Channel
from brace_drake.recording.read import LoadCampaign
from brace_drake.recording.recording import Campaign, Problem, Run
from brace_drake.recording.samples import Limits
from brace_drake.recording.write import WriteCampaign

__all__ = [
    "DEVICES",
    "Campaign",
    "Channel",
    "CheckCampaign",
    "Limits",
    "LoadCampaign",
    "Problem",
    "Run",
    "WriteCampaign",
]

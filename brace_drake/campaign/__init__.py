"""Campaigns: folders of recordings, read, checked and written."""

from brace_drake.campaign.check import CheckCampaign
from brace_drake.campaign.columns import DEVICES, Channel
from brace_drake.campaign.read import LoadCampaign
from brace_drake.campaign.recording import Campaign, Problem, Run
from brace_drake.campaign.samples import Limits
from brace_drake.campaign.write import WriteCampaign

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

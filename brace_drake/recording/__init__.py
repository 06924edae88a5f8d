"""Campaigns: folders of recordings, read, checked, written and imported.

What a device records, in which unit and range, is declared in `columns`, of an
axis with the sets of which it needs one in `ways`; what campaign.yaml may say,
in `manifest`. `read` follows both and decides whether a
folder can be used; `importing` makes campaigns of a lab's own files.
"""

from brace_drake.recording.columns import DEVICES, Channel
from brace_drake.recording.findings import Problem
from brace_drake.recording.read import (
    CheckCampaign,
    ExamineCampaign,
    LoadCampaign,
)
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.samples import Limits
from brace_drake.recording.write import WriteCampaign

__all__ = [
    "DEVICES",
    "Campaign",
    "Channel",
    "CheckCampaign",
    "ExamineCampaign",
    "Limits",
    "LoadCampaign",
    "Problem",
    "Run",
    "WriteCampaign",
]

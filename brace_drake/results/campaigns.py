"""Campaigns as users name them."""

from __future__ import annotations

from pathlib import Path

from brace_drake.recording import LoadCampaign
from brace_drake.recording.recording import Campaign


def load(path: str | Path) -> Campaign:
    """Reads and checks a campaign folder.

    Args:
        path: The folder that holds campaign.yaml.

    Returns:
        The campaign: `runs`, each with `channels` by name; `warnings` holds
        what the check found suspicious.

    Raises:
        CampaignError: The campaign has errors; one line with the first.
    """
    return LoadCampaign(path)


def as_campaign(given: str | Path | Campaign) -> Campaign:
    """A campaign, loaded where its folder is given."""
    return given if isinstance(given, Campaign) else LoadCampaign(given)

"""Loads a campaign folder that has no errors."""

from __future__ import annotations

import shlex
from pathlib import Path

from brace_drake.core.errors import CampaignError
from brace_drake.recording.check import ExamineCampaign
from brace_drake.recording.recording import Campaign


def LoadCampaign(path: str | Path) -> Campaign:
    """Reads and checks a campaign folder.

    Args:
        path: The folder that holds campaign.yaml.

    Returns:
        The campaign; `warnings` holds what the check found suspicious.

    Raises:
        CampaignError: The campaign has errors. The message is one line: the
            first error and how many more there are.
    """
    campaign, problems = ExamineCampaign(path)
    if campaign is not None:
        return campaign
    errors = [p for p in problems if p.severity == "error"]
    message = str(errors[0]).removeprefix("error: ")
    if not message.startswith(str(path)):
        message = f"{path}: {message}"
    if len(errors) > 1:
        command = f"brace-drake check {shlex.quote(str(path))}"
        message += f" (and {len(errors) - 1} more; run `{command}`)"
    raise CampaignError(message)

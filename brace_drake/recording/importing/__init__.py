"""Campaigns from and to other files: CSV, MATLAB, NI TDMS, MCAP.

A map (YAML) says which column of a lab's file is which channel; an MCAP file
that `WriteMcap` wrote holds a campaign as it is and needs none. A cell becomes
a number in `formats.cells` alone; a word in a column that is used is refused.
"""

from brace_drake.recording.importing.mapped import ImportCampaign
from brace_drake.recording.importing.mcap_file import (
    LoadMcapCampaign,
    WriteMcap,
)
from brace_drake.recording.importing.tables import LoadTable

__all__ = ["ImportCampaign", "LoadMcapCampaign", "LoadTable", "WriteMcap"]

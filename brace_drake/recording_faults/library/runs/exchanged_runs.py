"""Two files that stand in each other's place in the manifest."""

from brace_drake.recording_faults.card import RecordingFault

CARD = RecordingFault(
    name="exchanged_runs",
    title="files exchanged",
    law="the manifest describes each file as the other",
    signature="a repeat agrees with another run than the one that it names, or"
    " contact is wrong in two runs",
    remedy="exchange the two files, or their rows in campaign.yaml",
)

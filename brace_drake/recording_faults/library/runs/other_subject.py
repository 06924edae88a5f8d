"""Runs of another subject among a campaign's."""

from brace_drake.recording_faults.card import RecordingFault

CARD = RecordingFault(
    name="other_subject",
    title="another subject or machine",
    law="the subject's parameters differ between runs",
    signature="one subject fits some of the runs down to the noise and another"
    " the rest, no one both",
    remedy="a campaign holds one subject: make two campaigns of it",
    impostors={
        "posture_drift": "changes within each run",
        "hardening": "no linear subject fits a large motion down to the noise",
    },
)

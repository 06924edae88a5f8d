"""A machine of another geometry than the scenario's."""

from brace_drake.recording_faults.card import FaultParameter, RecordingFault

CARD = RecordingFault(
    name="other_geometry",
    title="another geometry than the scenario's",
    law="none",
    signature="leg lengths at rest are off those of the scenario by more than"
    " an error of encoders or anchors could be, and commands do not follow from"
    " the lengths",
    remedy="give the scenario of the machine that was recorded, --scenario",
    impostors={
        "encoder_offset": "at most 10 mm, and commands follow from lengths",
        "anchor_error": "commands follow from lengths",
    },
    parameters=(
        FaultParameter("largest_m", "m", "difference of a leg at rest"),
    ),
    is_of_run=True,
)

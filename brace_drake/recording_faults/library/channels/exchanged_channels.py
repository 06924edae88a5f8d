"""Two channels that stand in each other's column."""

from brace_drake.recording_faults.card import RecordingFault, with_columns


def _undo(columns, channels, values):
    """The first half of the channels in the second's columns, and back."""
    half = len(channels) // 2
    pairs = list(zip(channels[:half], channels[half:], strict=True))
    changed = {a: columns[b] for a, b in pairs}
    changed |= {b: columns[a] for a, b in pairs}
    return with_columns(columns, changed)


CARD = RecordingFault(
    name="exchanged_channels",
    title="exchanged",
    law="x_a,rec = x_b, x_b,rec = x_a",
    signature="the recorded commands do not follow from the recorded readings,"
    " and do with the two columns exchanged",
    remedy="exchange the two columns back, and check the wiring table",
    impostors={
        "anchor_error": "the controller knows nothing of it: commands still"
        " follow from readings"
    },
    undo=_undo,
)

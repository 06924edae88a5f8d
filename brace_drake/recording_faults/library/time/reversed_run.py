"""A run that is written from its end to its beginning."""

from brace_drake.recording_faults.card import RecordingFault, with_columns


def _undo(columns, channels, values):
    """Rows in the opposite order; rates of change turn their sign."""
    changed = {
        name: -series[::-1] if name.endswith("_m_s") else series[::-1]
        for name, series in columns.items()
        if name != "time_s"
    }
    return with_columns(columns, changed)


CARD = RecordingFault(
    name="reversed_run",
    title="written backwards in time",
    law="x_rec(t) = x(T - t)",
    signature="the twin of the other runs follows it from its end to its"
    " beginning, not the other way round",
    remedy="turn the order of the rows, or record the run again",
    impostors={"relaxation": "has one direction of time in all runs"},
    undo=_undo,
    is_of_run=True,
)

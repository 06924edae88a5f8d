"""Channels of all legs that are numbered in another way."""

import numpy as np

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)


def order_of(values, size: int) -> np.ndarray:
    """Which column holds leg k (size,): counted backwards, then turned on."""
    order = np.arange(size)
    if values["reversed"]:
        order = order[::-1]
    return (order + int(values["shift"])) % size


def _undo(columns, channels, values):
    order = order_of(values, len(channels))
    changed = {
        name: columns[channels[k]]
        for name, k in zip(channels, order, strict=True)
    }
    return with_columns(columns, changed)


CARD = RecordingFault(
    name="permuted_channels",
    title="numbered in another order",
    law="x_k = x_rec,(k + shift), or x_rec,(n - 1 - k + shift) where reversed",
    signature="as of exchanged channels, for all of them",
    remedy="number the legs as the scenario does, see its anchors",
    parameters=(
        FaultParameter("shift", "1", "places that the numbers are turned by"),
        FaultParameter("reversed", "1", "1 where they are counted backwards"),
    ),
    undo=_undo,
)

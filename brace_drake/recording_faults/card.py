"""The card of a recording fault: its law, its signature, its remedy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from brace_drake.recording.table import Columns

# From columns, the faulty channels and the fault's parameters to the columns
# as they would have been without it.
Undo = Callable[[Columns, tuple[str, ...], Mapping[str, float]], Columns]


@dataclass(frozen=True)
class FaultParameter:
    """One parameter of a recording fault.

    Attributes:
        name: With its unit as the last part, where it has one.
        unit: SI; "1" without.
        meaning: One line.
    """

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class RecordingFault:
    """A card: what the recorder made of the truth, and what tells it.

    Attributes:
        name: Identifier as in a diagnosis.
        title: What was done to the channels or runs, to follow their names.
        law: The recording as a function of the truth, in plain text.
        signature: What it looks like in a campaign.
        remedy: What the user can do.
        impostors: Effects of the machine that it is confused with, and
            what tells them apart.
        parameters: In the order in which they are reported.
        undo: Takes the fault back; None where nothing can.
        is_of_run: Whether its parameters tell of one run, as when a sensor got
            stuck, and not of the recorder, as a scale does.
    """

    name: str
    title: str
    law: str
    signature: str
    remedy: str
    impostors: Mapping[str, str] = field(default_factory=dict)
    parameters: tuple[FaultParameter, ...] = ()
    undo: Undo | None = None
    is_of_run: bool = False


def with_columns(
    columns: Columns, changed: Mapping[str, np.ndarray]
) -> Columns:
    """Columns with some of them replaced; the rest is shared."""
    return {**columns, **changed}

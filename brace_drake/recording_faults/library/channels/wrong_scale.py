"""A channel in another unit, or with the wrong scale."""

from __future__ import annotations

from brace_drake.recording_faults.card import (
    FaultParameter,
    RecordingFault,
    with_columns,
)

# What one SI unit reads in others, by unit.
UNITS = {
    "N": {
        "kgf": 1.0 / 9.80665,
        "lbf": 1.0 / 4.4482216,
        "mN": 1e3,
        "cN": 1e2,
        "kN": 1e-3,
        "ozf": 1.0 / 0.27801385,
    },
    "m": {
        "mm": 1e3,
        "cm": 1e2,
        "inch": 1.0 / 0.0254,
        "ft": 1.0 / 0.3048,
        "um": 1e6,
    },
}
# How near a fitted scale is to that of a unit, relative.
_NEAR = 0.02


def unit_of_scale(unit: str, scale: float) -> str | None:
    """The unit that a scale stands for, None where it is none's."""
    for name, size in UNITS.get(unit, {}).items():
        if abs(scale / size - 1.0) < _NEAR:
            return name
    return None


def _undo(columns, channels, values):
    scale, zero = values["scale"], values.get("zero", 0.0)
    return with_columns(
        columns, {c: zero + (columns[c] - zero) / scale for c in channels}
    )


CARD = RecordingFault(
    name="wrong_scale",
    title="recorded with a wrong unit or scale",
    law="x_rec - zero = scale (x - zero)",
    signature="the channel is as many times too large in every sample, and"
    " the controller has not read it so",
    remedy="divide the column by the scale, or name its unit in its header;"
    " where the machine is not the scenario's, name its own scenario",
    impostors={
        "force_scale": "the controller reads it too: commands still follow"
        " from readings",
        "weak_leg": "the drive gives less than the command that is recorded",
    },
    parameters=(
        FaultParameter("scale", "1", "recorded over true"),
        FaultParameter("zero", "of the channel", "value that stays the same"),
    ),
    undo=_undo,
)

"""Ticks of a motion on a device, and the columns that they are written in."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from brace_drake.devices.motions.reference import reference_columns
from brace_drake.recording.columns import (
    BENCH,
    BRACE,
    BRACE_STAGES,
    device_channels,
)

# Numbers of a device's moving rings, bottom to top.
Rings = tuple[int, ...]
# Beside the channels of the device's format.
_LINE = ("bridged", "command_age_ticks", "latency_us")
_LENGTH, _COMMAND = "_length_m", "_force_command_N"


@dataclass
class Row:
    """One control tick as it was recorded.

    Attributes:
        tick: Of the motion; below 0 while the ring settles.
        command: Leg commands computed at it (6 S,), N.
        readings: Lengths, forces, marker (9 S + 3,).
        desired: y_d, y_d', y_d'' (3, S).
        y_virtual: Of each ring (S,), m.
        y_ring: Displacement of each ring along y (S,), m.
        latency: From the state's arrival to the command's departure, s.
        age: Ticks between the state and that which the command in use answers.
        bridged: Whether the state was lost and its readings are interpolated.
        stiffness: K_d along y in use, of each ring (S,), N/m.
    """

    tick: int
    command: np.ndarray
    readings: np.ndarray
    desired: np.ndarray
    y_virtual: np.ndarray
    y_ring: np.ndarray
    latency: float
    age: int
    bridged: bool = False
    stiffness: np.ndarray | None = None


def campaign_device(rings: Rings) -> tuple[str, tuple[int, ...]]:
    """Device of a campaign, and the stages that it names: none for all.

    Stage 2 alone is the bench.
    """
    if rings == (2,):
        return BENCH, ()
    return BRACE, () if rings == BRACE_STAGES else rings


@cache
def columns_of(rings: Rings) -> tuple[str, ...]:
    """Columns of a recording through the link."""
    return (*device_channels(*campaign_device(rings)), *_LINE)


@cache
def reading_names(rings: Rings) -> tuple[str, ...]:
    """Names of what a device reads: lengths, forces, marker."""
    return (
        *(n for n in columns_of(rings) if n.endswith(_LENGTH)),
        *(f"ring{i}_force_{axis}_N" for i in rings for axis in "xyz"),
        *(f"torso_{axis}_m" for axis in "xyz"),
    )


@cache
def _command_names(rings: Rings) -> tuple[str, ...]:
    lengths = reading_names(rings)[: 6 * len(rings)]
    return tuple(n.replace(_LENGTH, _COMMAND) for n in lengths)


@cache
def log_columns(rings: Rings) -> tuple[str, ...]:
    """Columns of a log of every tick."""
    of_ring = ("y_desired_m", "y_virtual_m", "y_m", "y_stiffness_N_m")
    return (
        "tick",
        *_command_names(rings),
        *reading_names(rings)[:-3],
        *(f"ring{i}_{name}" for i in rings for name in of_ring),
        *reversed(_LINE),
    )


def name_values(row: Row, rings: Rings) -> dict[str, float]:
    """All numbers of a tick by the names of their columns."""
    values = dict(zip(_command_names(rings), row.command, strict=True))
    values |= dict(zip(reading_names(rings), row.readings, strict=True))
    reference = np.reshape(row.desired, (3, -1))
    for i, ring in enumerate(rings):
        names = reference_columns(ring)
        values |= dict(zip(names, reference[:, i], strict=True))
        values[f"ring{ring}_y_virtual_m"] = row.y_virtual[i]
        values[f"ring{ring}_y_m"] = row.y_ring[i]
        values[f"ring{ring}_y_stiffness_N_m"] = row.stiffness[i]
    line = (row.bridged, row.age, round(1e6 * row.latency))
    return values | dict(zip(_LINE, line, strict=True)) | {"tick": row.tick}

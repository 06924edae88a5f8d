"""Names of what a device's ticks hold, as its recordings have them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.motions.reference import reference_columns
from brace_drake.link.operation.rows import Row
from brace_drake.recording.columns import BENCH, BRACE_STAGES, device_channels

# Beside the channels of the device's format.
_EXTRA = ("bridged", "command_age_ticks", "latency_us")


def leg_names(rings: Sequence[int]) -> list[str]:
    """Names of the legs below the moving rings, as `simulate` has them.

    Of the whole brace legs 1 to 18; of stage 2 alone, the bench, 1 to 6.
    """
    lowest = 1 if tuple(rings) == (2,) else rings[0]
    first = 6 * (lowest - 1) + 1
    return [f"leg{k}" for k in range(first, first + 6 * len(rings))]


def rings_of(device: str, stages: Sequence[int] = ()) -> tuple[int, ...]:
    """Moving rings of a recording's device; no stages: all that it has."""
    if device == BENCH:
        return (2,)
    return tuple(stages) or BRACE_STAGES


def columns_of(device: str, stages: Sequence[int] = ()) -> tuple[str, ...]:
    """Columns of a recording through the link."""
    return (*device_channels(device, stages), *_EXTRA)


def arrange_row(
    row: Row, period: float, device: str, stages: Sequence[int] = ()
) -> list[float]:
    """A tick's numbers in the order of `columns_of`."""
    rings = rings_of(device, stages)
    legs = leg_names(rings)
    values = {"time_s": row.tick * period}
    for k, leg in enumerate(legs):
        values[f"{leg}_force_command_N"] = row.command[k]
        values[f"{leg}_length_m"] = row.readings[k]
    forces = row.readings[len(legs) : -3].reshape((-1, 3))
    references = np.reshape(row.desired, (3, -1)).T
    for i, ring in enumerate(rings):
        for axis, force in zip("xyz", forces[i], strict=True):
            values[f"ring{ring}_force_{axis}_N"] = force
        names = reference_columns(ring)
        values |= dict(zip(names, references[i], strict=True))
        values[f"ring{ring}_y_virtual_m"] = row.y_virtual[i]
    for axis, marker in zip("xyz", row.readings[-3:], strict=True):
        values[f"torso_{axis}_m"] = marker
    channels = device_channels(device, stages)
    ordered = [float(values[name]) + 0.0 for name in channels]
    return [*ordered, row.bridged, row.age, round(1e6 * row.latency)]

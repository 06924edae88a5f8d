"""A machine that nothing else drives takes work, over a run, and gives none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.channels import reversed_sign

# Part of the work, taken without its sign, that has to come back in all.
_GIVEN = 0.3


def find_given_work(device: Device, runs: Sequence[Run]) -> list[Finding]:
    """Runs in which the force on a passive machine takes work out of it."""
    if device.takes_work is None:
        return []
    force, way = device.takes_work
    found = []
    for run in runs:
        if not {force, way} <= set(run.channels):
            continue
        F, y = run.channels[force], run.channels[way]
        # What a constant load does over a way and back is none of it.
        work = 0.5 * ((F - F.mean())[1:] + (F - F.mean())[:-1]) * np.diff(y)
        given, moved = float(work.sum()), float(np.abs(work).sum())
        if moved > 0.0 and given < -_GIVEN * moved:
            detail = (
                f"over the run it takes {-given:.3g} J out of the machine,"
                " which nothing else drives"
            )
            found.append(
                Finding(
                    reversed_sign.CARD,
                    (run.file,),
                    (force,),
                    {"zero": 0.0},
                    0.95,
                    detail,
                )
            )
    return found

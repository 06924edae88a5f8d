"""A machine that nothing else drives takes work, over a run, and gives none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.relations.pressing import reversed_channel

# What a passive machine gives back is no more than it took: work that is never
# above this part of what has come out says that the force is the wrong way
# round. Only where the run ends near where it began, in parts of its range, is
# that not what a spring had in store.
_TAKEN, _NEAR = 0.1, 0.2
# And more than so many deviations of what noise makes of it.
_CLEAR = 8.0


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
        F = F - F.mean()
        work = np.cumsum(0.5 * (F[1:] + F[:-1]) * np.diff(y))
        returns = abs(y[-1] - y[0]) < _NEAR * float(np.ptp(y))
        given, taken = -float(work.min()), float(work.max())
        noise = float(np.std(np.diff(F))) / np.sqrt(2.0)
        least = _CLEAR * noise * float(np.linalg.norm(np.diff(y)))
        is_clear = given > max(least, taken / _TAKEN) and work[-1] < 0.0
        if returns and is_clear:
            detail = (
                f"it takes {given:.3g} J out of the machine,"
                " which nothing else drives"
            )
            found.append(reversed_channel(run, force, detail))
    return found

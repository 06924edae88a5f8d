"""A pad that is not glued presses, and the more the deeper it is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.recording.forces import smoothed
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.channels import reversed_sign
from brace_drake.recording_faults.library.runs import contradiction

# A pull that is told: in deviations of the smoothed noise, and as a part of the
# largest force.
_CLEAR, _PART = 8.0, 0.1
# Correlation of force and way from which on the way is the wrong way round.
_AGAINST = -0.8


def find_press_faults(device: Device, runs: Sequence[Run]) -> list[Finding]:
    """Runs in which a pad pulls, or presses where it is drawn back."""
    if device.presses is None:
        return []
    force, way = device.presses
    return [
        found
        for run in runs
        if run.contact and {force, way} <= set(run.channels)
        for found in [_of_run(run, force, way, device.rate)]
        if found is not None
    ]


def _of_run(run: Run, force: str, way: str, rate: float) -> Finding | None:
    noise = float(np.std(np.diff(run.channels[force]))) / np.sqrt(2.0)
    slow = smoothed(run.channels[force], rate)
    pull, push = -float(slow.min()), float(slow.max())
    clear = _CLEAR * noise / np.sqrt(0.1 * rate)
    least = max(clear, _PART * max(pull, push))
    detail = f"it pulls with up to {pull:.3g} N, and a pad can only press"
    if pull > least and push < least:
        return reversed_channel(run, force, detail)
    if pull > least:
        return Finding(
            contradiction.CARD,
            (run.file,),
            (force,),
            {},
            0.8,
            detail,
            severity="warning",
        )
    moved = smoothed(run.channels[way], rate)
    if push < clear or not np.std(moved) > 0.0:
        return None
    if float(np.corrcoef(slow, moved)[0, 1]) < _AGAINST:
        return reversed_channel(
            run, way, "the force grows where it is drawn back"
        )
    return None


def reversed_channel(run: Run, channel: str, detail: str) -> Finding:
    """A channel of a run with its sign turned."""
    card = reversed_sign.CARD
    return Finding(card, (run.file,), (channel,), {"zero": 0.0}, 0.95, detail)

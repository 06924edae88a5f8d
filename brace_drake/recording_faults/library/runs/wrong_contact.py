"""A run with the torso that is called free, or the other way round."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.recording.forces import smoothed
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import FaultParameter, RecordingFault
from brace_drake.recording_faults.finding import Finding

CARD = RecordingFault(
    name="wrong_contact",
    title="wrong contact in the manifest",
    law="contact of the manifest is not that of the run",
    signature="a ring that moves feels nothing where a torso should be, or a"
    " force that goes with its motion where none should",
    remedy="correct contact in campaign.yaml, or the file that is exchanged",
    parameters=(
        FaultParameter("force_N", "N", "range of the force along the push"),
    ),
    is_of_run=True,
)
# Part of the least push of any subject below which there is no torso: effects
# such as a clearance take some of it.
_NOTHING = 0.2
# Above its own noise a push must be to be told, and how it follows the ring.
_CLEAR, _FOLLOWS = 8.0, 0.8


def find_wrong_contact(device: Device, runs: Sequence[Run]) -> list[Finding]:
    """Runs whose force along the push is not that of their contact."""
    return [f for run in runs for f in _of_run(device, run)]


def _of_run(device: Device, run: Run) -> list[Finding]:
    expected = device.least_push(run)
    if expected is None:
        return []
    name, least, asked = expected
    force = run.channels[name]
    slow = smoothed(force, device.rate)
    noise = float(np.std(np.diff(force))) / np.sqrt(2.0)
    felt, noise = float(np.ptp(slow)), noise / np.sqrt(0.1 * device.rate)
    if _NOTHING * least < _CLEAR * noise:
        return []
    if run.contact and felt < _NOTHING * least:
        detail = (
            f"contact: true, but a motion that pushes any torso with"
            f" {least:.2g} N and more is felt as {felt:.2g} N"
        )
    elif not run.contact and felt > least and _follows(slow, asked, device):
        detail = (
            f"contact: false, but {name} follows the motion with {felt:.2g} N"
        )
    else:
        return []
    return [
        Finding(
            CARD,
            (run.file,),
            (),
            {"force_N": felt},
            0.98,
            detail,
        )
    ]


def _follows(force: np.ndarray, asked: np.ndarray, device: Device) -> bool:
    asked = smoothed(asked, device.rate)
    return abs(float(np.corrcoef(force, asked)[0, 1])) > _FOLLOWS

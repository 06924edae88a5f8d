"""Runs beside the twin: what readings are, and what they should have been."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.cosine_transform import to_frequency
from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.recording_faults.statistics import (
    LOCAL_VARIANCE,
    noise_deviation,
)


@dataclass(frozen=True)
class Reading:
    """Channels of one run beside the twin's.

    Attributes:
        prepared: The run.
        expected: Of the twin (N, C).
        names: Of its channels.
    """

    prepared: PreparedRun
    expected: np.ndarray
    names: tuple[str, ...]

    def squares(self, columns: dict[str, np.ndarray]) -> dict[str, float]:
        """Mean square of each column's difference from the twin, in floors."""
        found = {}
        for name, values in columns.items():
            c = self.names.index(name)
            if not self.prepared.used[c]:
                continue
            # With a fault undone a run may be shorter.
            expected = self.expected[: len(values), c]
            difference = to_frequency(values - expected)
            weights = self.prepared.weights[:, c]
            weighted = difference[: len(weights)] * weights[: len(values)]
            found[name] = float(np.mean(weighted**2))
        return found

    def noise_ratio(self, name: str) -> float:
        """A recorded reading's noise over the twin's, by what changes from
        sample to sample; infinite where the twin's has none.
        """
        floor = self.prepared.floor
        white = float(floor.density[-1, self.names.index(name)])
        noise = noise_deviation(self.prepared.run.channels[name])
        least = np.sqrt(LOCAL_VARIANCE * white)
        return noise / least if least > 0.0 else np.inf

    def unread(self, names: Sequence[str]) -> dict[str, float]:
        """The same of those of some channels that the run has."""
        channels = self.prepared.run.channels
        return self.squares({n: channels[n] for n in names if n in channels})


def unread_channels(device: Device) -> tuple[str, ...]:
    """Channels of a device that its controller does not read or compute."""
    law = device.control_law
    if law is None:
        return ()
    known = {*law.outputs, *(n for names in law.by_output for n in names)}
    return tuple(n for n in device.twin.channels if n not in known)


def read_runs(
    device: Device,
    evaluator: Evaluator,
    runs: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
) -> list[Reading]:
    """Runs with the torso beside the twin of a subject.

    Args:
        device: Of the runs.
        evaluator: Of its twin.
        runs: As prepared.
        subject, uses: Of the twin.
    """
    channels = device.twin.channels
    return [
        Reading(p, evaluator.simulate(p, subject, uses), channels)
        for p in runs
        if p.run.contact
    ]

"""The leg bench, one drive alone, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from brace_drake.devices.declaration import Device, MotionSignals
from brace_drake.devices.leg_bench.block_tests import leg_tests
from brace_drake.devices.leg_bench.control_law import DriveControlLaw
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.devices.motions.library import MotionSet
from brace_drake.devices.motions.limits import leg_motions
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.leg_bench import MakeLegBenchScenario


class LegBench(Device):
    """Device of leg bench campaigns."""

    words = MappingProxyType(
        {
            "force_error_N": ("Command", "N"),
            "position_error_mm": ("Position", "mm"),
        }
    )

    def __init__(self, campaign: Campaign, scenario=None):
        twin = LegBenchTwin(scenario or MakeLegBenchScenario(campaign))
        super().__init__(twin, campaign.rate_hz, leg_tests(twin))
        if twin.numbers.is_closed_loop:
            self.control_law = DriveControlLaw(twin)

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What users ask for: command, N, and position, mm."""
        position = 1e3 * x[:, [1]]
        return {"force_error_N": x[:, [0]], "position_error_mm": position}

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """Reference, or else position, of a run; no force."""
        channels = prepared.run.channels
        position = channels.get("position_desired_m", channels["position_m"])
        return MotionSignals(position, None, None, position, "position")

    def motions(self, runs: Sequence[Run]) -> MotionSet | None:
        """Ways within what was recorded; none in open loop."""
        return leg_motions(self.twin, runs, self.rate)

"""The pad bench, a pad pressed into tissue, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from brace_drake.devices.declaration import Device, MotionSignals
from brace_drake.devices.motions.library import MotionSet
from brace_drake.devices.motions.limits import pad_motions
from brace_drake.devices.pad_bench.block_tests import TOUCH, pad_tests
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.pad_bench import MakePadBenchScenario


class PadBench(Device):
    """Device of pad bench campaigns."""

    words = MappingProxyType({"force_error_N": ("Force of the pad", "N")})

    presses = ("force_N", "displacement_m")
    takes_subjects = True

    def __init__(self, campaign: Campaign, scenario=None):
        twin = PadBenchTwin(scenario or MakePadBenchScenario(campaign))
        super().__init__(twin, campaign.rate_hz, pad_tests(twin))

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What users ask for: the force of the pad, N."""
        return {"force_error_N": x}

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """Displacement and force of a run; the pad touches where there is
        any.
        """
        force = prepared.measured[:, 0]
        touching = force[:, None] > TOUCH * prepared.motion.sigma
        way = prepared.motion.displacement
        return MotionSignals(way, 0, touching, way, "position")

    def motions(self, runs: Sequence[Run]) -> MotionSet:
        """Ways with no more force than recorded."""
        return pad_motions(self.twin, runs, self.rate)

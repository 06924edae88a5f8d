"""A whole brace on a torso, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from brace_drake.devices.bench.recorded_motion import ring_poses
from brace_drake.devices.brace.tolerances import (
    brace_tolerances,
    brace_uses_off,
)
from brace_drake.devices.brace.twin import BraceTwin
from brace_drake.devices.declaration import (
    Device,
    MotionSignals,
    Nuisance,
)
from brace_drake.devices.motions.library import MotionSet
from brace_drake.devices.motions.reference import reference_columns
from brace_drake.effects.stack import Use
from brace_drake.recording.columns import BRACE_STAGES
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.brace import BraceScenario


class Brace(Device):
    """Device of campaigns of several stages."""

    words = MappingProxyType(
        {
            "force_error_N": ("Forces on the torso", "N"),
            "ring_error_mm": ("Positions of the rings", "mm"),
        }
    )
    takes_subjects = True

    def __init__(self, campaign: Campaign, scenario=None):
        stages = list(campaign.stages or BRACE_STAGES)
        scenario = scenario or BraceScenario(stages=stages)
        super().__init__(BraceTwin(scenario), campaign.rate_hz, [])

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What a therapist asks for: forces, N, and ring positions, mm."""
        n = self.twin.numbers.num_stages
        poses, _ = ring_poses(self.twin.numbers, x[:, 6 * n : 12 * n])
        rings = poses.reshape(len(x), n, 6)[:, :, 0:3].reshape(len(x), 3 * n)
        return {
            "force_error_N": x[:, 12 * n : 15 * n],
            "ring_error_mm": 1e3 * rings,
        }

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """Along the push of the ring that moves farthest."""
        twin, run = self.twin, prepared.run
        names = {
            i: reference_columns(stage)[0]
            for i, stage in enumerate(twin.scenario.stages)
        }
        ways = {i: run.channels.get(n) for i, n in names.items()}
        asked = {i: w for i, w in ways.items() if w is not None}
        moved = max(asked, key=lambda i: float(np.ptp(asked[i])), default=0)
        force = 12 * twin.numbers.num_stages + 3 * moved + 1
        way = asked.get(moved, np.zeros(len(run.time_s)))
        return MotionSignals(way, force, None, way, "ring")

    def tolerances(self) -> list[Nuisance]:
        """Of the numbers that its scenario states or assumes, of each stage."""
        return brace_tolerances(self.twin.scenario)

    def uses_off(self, off: Mapping[str, float]) -> tuple[Use, ...]:
        """All in one effect."""
        return brace_uses_off(self.twin.scenario, off)

    def motions(self, runs: Sequence[Run]) -> MotionSet | None:
        """None: no motion of several rings is known to be safe."""
        return None

"""An axis, any machine of one degree of freedom, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.axis.nominal import MakeAxisScenario
from brace_drake.devices.axis.twin import AxisTwin
from brace_drake.devices.declaration import BlockTest, Device, MotionSignals
from brace_drake.devices.motions.library import MotionSet
from brace_drake.recording.recording import Campaign, Run


class Axis(Device):
    """Device of axis campaigns."""

    def __init__(self, campaign: Campaign, scenario=None):
        twin = AxisTwin(scenario or MakeAxisScenario(campaign))
        test = BlockTest(
            "actuation",
            "motion",
            "force that it takes",
            lambda prepared, x: _residual_of_drive(twin, prepared, x),
        )
        super().__init__(twin, campaign.rate_hz, [test])
        title = ("Torque", "N m") if twin.units.is_rotary else ("Force", "N")
        self.words = {"force_error_N": title}
        self.takes_work = twin.channels[0], twin.position

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What users ask for: the force, N, or torque, N m."""
        return {"force_error_N": x}

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """Position of a run, and the force along it."""
        way = prepared.motion.way.displacement
        return MotionSignals(way, 0, None, way, "position")

    def motions(self, runs: Sequence[Run]) -> MotionSet | None:
        """None: how the machine is moved is not known."""
        return None


def _residual_of_drive(twin: AxisTwin, prepared, x: np.ndarray):
    """Force less that of the nominal law on the recorded motion."""

    def residual(subject):
        return (x - twin.simulate(prepared.motion, subject))[:, 0]

    return residual

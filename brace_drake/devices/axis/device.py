"""An axis, any machine of one degree of freedom, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from brace_drake.devices.axis.follower import AxisFollower
from brace_drake.devices.axis.nominal import MakeAxisScenario
from brace_drake.devices.axis.twin import AxisTwin
from brace_drake.devices.declaration import BlockTest, Device, MotionSignals
from brace_drake.devices.motions.library import MotionSet
from brace_drake.recording.recording import Campaign, Run


class Axis(Device):
    """Device of axis campaigns."""

    def __init__(self, campaign: Campaign, scenario=None):
        scenario = scenario or MakeAxisScenario(campaign)
        is_imposed = scenario.is_imposed
        twin = (AxisTwin if is_imposed else AxisFollower)(scenario)
        given, found = "motion", "force that it takes"
        if not is_imposed:
            given, found = "command", "motion"
        if scenario.command == "motor":
            given, found = "motion of the motor", "motion of the load"
        test = BlockTest("actuation", given, found, partial(_residual, twin))
        super().__init__(twin, campaign.rate_hz, [test])
        length = "rad" if twin.units.is_rotary else "m"
        if is_imposed:
            force = (
                ("Torque", "N m") if twin.units.is_rotary else ("Force", "N")
            )
            self.words = {"force_error_N": force}
            self.takes_work = twin.channels[0], twin.position
        else:
            unit = f"{length}/s" if scenario.command == "speed" else length
            name = "Speed" if scenario.command == "speed" else "Position"
            self.words = {"motion_error": (name, unit)}

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What users ask for: force or torque; under a command, motion."""
        return {name: x for name in self.words}

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """Position of a run, and the force along it."""
        way = prepared.run.channels[self.twin.position]
        force = 0 if self.takes_work else None
        return MotionSignals(way, force, None, way, "position")

    def motions(self, runs: Sequence[Run]) -> MotionSet | None:
        """None: how the machine is moved is not known."""
        return None


def _residual(twin, prepared, x: np.ndarray):
    """What is measured less what the nominal law makes of what is given."""

    def residual(subject):
        return (x - twin.simulate(prepared.motion, subject))[:, 0]

    return residual

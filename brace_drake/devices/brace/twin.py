"""The twin of a whole brace as fits and diagnoses see it."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin, settled_reference
from brace_drake.devices.motions.reference import references_of_rings
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BraceScenario


class BraceTwin(BenchTwin):
    """Replays recorded references of all rings on the compiled brace."""

    def __init__(self, scenario: BraceScenario, time_step: float | None = None):
        super().__init__(scenario, time_step)
        self.channels = brace_channels(scenario)

    def motion(self, run: Run) -> Motion:
        """The references of a recorded run at control ticks; rings without
        one are held.
        """
        scenario = self.scenario
        rings = len(scenario.stages)
        samples = np.zeros((len(run.time_s), 3, rings))
        for i, own in references_of_rings(run, scenario.stages, "brace"):
            samples[:, :, i] = own
        rate = scenario.control.rate
        desired, every, settled = settled_reference(run, samples, rate)
        columns = tuple(6 * i + 1 for i in range(rings))
        return Motion(desired, run.contact, every, settled, columns)


def brace_channels(scenario: BraceScenario) -> tuple[str, ...]:
    """Columns of a brace's log, in its order."""
    legs = [6 * (s - 1) + k for s in scenario.stages for k in range(1, 7)]
    return (
        *(f"leg{k}_force_command_N" for k in legs),
        *(f"leg{k}_length_m" for k in legs),
        *(f"{ring}_force_{a}_N" for ring in scenario.rings for a in "xyz"),
        *(f"torso_{a}_m" for a in "xyz"),
        *(f"{ring}_y_virtual_m" for ring in scenario.rings),
    )

"""The bench of a scenario as an emulated plant."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.subject import with_subject
from brace_drake.effects.stack import Use
from brace_drake.link.emulator.plant import EmulatedPlant
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench
from brace_drake.scenario.effects import scenario_uses


class BenchPlant(EmulatedPlant):
    """Ring, torso, legs and instruments of one bench."""

    def __init__(
        self,
        scenario: BenchScenario,
        uses: tuple[Use, ...] = (),
        subject: np.ndarray | None = None,
        seed: int | None = 0,
    ):
        numbers = pack_bench(scenario)
        if subject is not None:
            numbers = with_subject(numbers, subject)
        uses = (*scenario_uses(scenario), *uses)
        present = scenario.torso.present
        super().__init__(numbers, scenario.time_step, uses, present, seed)

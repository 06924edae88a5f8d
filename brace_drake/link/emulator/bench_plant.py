"""The bench of a scenario as an emulated plant."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.rollout import rest_state
from brace_drake.devices.subject import with_subject
from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.link.emulator.plant import (
    EmulatedPlant,
    PlantNumbers,
    PlantTiming,
)
from brace_drake.scenario.bench_numbers import (
    BenchNumbers,
    hold_forces,
    pack_bench,
)
from brace_drake.scenario.brace import BenchScenario
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
        hold = hold_forces(numbers)
        uses = (*scenario_uses(scenario), *uses)
        numbers = modify_numbers(numbers, uses)
        period = 1.0 / scenario.control.rate
        super().__init__(
            _pack_plant(numbers),
            PlantTiming(period, round(period / scenario.time_step)),
            hold,
            stack_effects(uses, numbers),
            scenario.torso.present,
            seed,
        )


def _pack_plant(numbers: BenchNumbers) -> PlantNumbers:
    return PlantNumbers(
        lower=numbers.p_WB[None],
        upper=numbers.p_RT[None],
        rest=numbers.rest[None],
        start=rest_state(numbers.rest)[None, 0:7],
        torso_rest=numbers.rest,
        viscous=numbers.viscous,
        contact=numbers.contact[None],
        posture=numbers.posture,
        rings=numbers.ring[None],
        torso=numbers.torso,
        resolution=numbers.resolution,
        noise_sigma=numbers.noise_sigma,
    )

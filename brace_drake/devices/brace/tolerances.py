"""Numbers of a whole brace that are known to a tolerance, stage by stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from brace_drake.devices.bench.tolerances import bench_tolerances
from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.stack import Use
from brace_drake.effects.stage_cards import of_stage, stages_within_tolerances
from brace_drake.scenario.brace import BraceScenario


def brace_tolerances(scenario: BraceScenario) -> list[Nuisance]:
    """What each stage may be off without being a finding, see
    `bench_tolerances`.
    """
    stages = scenario.stages
    return [
        _of_stage(nuisance, index, stages)
        for index in range(len(stages))
        for nuisance in bench_tolerances(scenario)
    ]


def _of_stage(nuisance: Nuisance, index: int, stages: list[int]) -> Nuisance:
    uses = tuple(
        (of_stage(card, index, stages), values)
        for card, values in nuisance.uses
    )
    name = f"stage{stages[index]}_{nuisance.name}"
    return replace(nuisance, name=name, uses=uses)


def brace_uses_off(
    scenario: BraceScenario, off: Mapping[str, float]
) -> tuple[Use, ...]:
    """All in one effect; what cannot be below its limit is at it."""
    if not any(off.values()):
        return ()
    card = stages_within_tolerances(scenario.stages)
    values = [
        max(off.get(p.name, 0.0), p.lower)
        if p.lower >= 0.0
        else off.get(p.name, 0.0)
        for p in card.parameters
    ]
    return ((card, np.array(values)),)

"""Numbers of the bench known to a tolerance, as effects of its twin."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.card import Effect
from brace_drake.effects.within_tolerances import ANCHORS, NUMBERS
from brace_drake.scenario.brace import BenchScenario

# Name in the scenario of each number's tolerance.
KEYS = {
    "ring_mass_kg": "ring_mass",
    "leg_viscous_N_s_m": "leg_viscous",
    "leg_dry_friction_N": "leg_dry_friction",
    "force_scale": "force_scale",
    "force_bias_N": "force_bias",
    "command_delay_s": "command_delay",
}
# What only adds to a number.
_ONE_SIDED = ("leg_dry_friction_N", "command_delay_s")


def bench_tolerances(scenario: BenchScenario) -> list[Nuisance]:
    """What may be off on a bench without being a finding.

    Mass of the ring, friction of the legs, gain and zero of the force reading,
    a tick of delay, 36 coordinates of the legs' anchors; those without a
    tolerance are left out.
    """
    return [n for n in _all(scenario) if n.deviation > 0.0]


def _all(scenario: BenchScenario) -> Iterator[Nuisance]:
    for name, card in NUMBERS.items():
        size = getattr(scenario.tolerances, KEYS[name])
        lower = 0.0 if name in _ONE_SIDED else -math.inf
        yield _nuisance(name, card, size, np.array([size]), lower)
    names, size = ANCHORS.parameter_names, scenario.tolerances.anchor
    for name, values in zip(names, size * np.eye(len(names)), strict=True):
        yield _nuisance(name, ANCHORS, size, values, -math.inf)


def _nuisance(
    name: str, card: Effect, size: float, values: np.ndarray, lower: float
) -> Nuisance:
    unit = card.parameters[0].unit
    return Nuisance(name, unit, card.block, size, ((card, values),), lower)

"""Numbers of the bench known to a tolerance, as effects of its twin."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.scenario.brace import BenchScenario

# Name, tolerance of the scenario, effect that puts the number off, and the
# least that it can be, in deviations.
_NUMBERS = (
    ("ring_mass_kg", "ring_mass", "ring_mass", -math.inf),
    ("leg_viscous_N_s_m", "leg_viscous", "viscous_leg", -math.inf),
    ("leg_dry_friction_N", "leg_dry_friction", "coulomb_friction", 0.0),
    ("force_scale", "force_scale", "force_scale", -math.inf),
    ("force_bias_N", "force_bias", "force_bias", -math.inf),
    ("command_delay_s", "command_delay", "command_delay", 0.0),
)


def bench_tolerances(scenario: BenchScenario) -> list[Nuisance]:
    """What may be off on a bench without being a finding.

    Mass of the ring, friction of the legs, 36 coordinates of their anchors,
    gain and zero of the force reading, a tick of delay; those without a
    tolerance are left out.
    """
    return [n for n in _all(scenario) if n.deviation > 0.0]


def _all(scenario: BenchScenario) -> Iterator[Nuisance]:
    for name, tolerance, effect, lower in _NUMBERS:
        size = getattr(scenario.tolerances, tolerance)
        card = find_effect(effect)
        yield _nuisance(name, card, size, np.array([size]), lower)
    card, size = find_effect("anchor_error"), scenario.tolerances.anchor
    names = card.parameter_names
    for name, values in zip(names, size * np.eye(len(names)), strict=True):
        yield _nuisance(name, card, size, values, -math.inf)


def _nuisance(
    name: str, card: Effect, size: float, values: np.ndarray, lower: float
) -> Nuisance:
    unit = card.parameters[0].unit
    return Nuisance(name, unit, card.block, size, ((card, values),), lower)

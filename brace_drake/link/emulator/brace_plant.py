"""A brace of several stages, in task space, as an emulated plant."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.effects.stack import Use, stack_laws
from brace_drake.kinematics import holding_leg_forces
from brace_drake.laws.stages import place_rings
from brace_drake.link.emulator.plant import (
    EmulatedPlant,
    PlantNumbers,
    PlantTiming,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace


class BracePlant(EmulatedPlant):
    """Rings, torso, legs and instruments of a brace.

    The compiled laws of the diagram (`brace_drake.model.brace_station`), with
    the stages that the scenario picks.

    Effects that are laws act on every stage alike, on the torso once; those
    that are other numbers of the bench are not for a brace.
    """

    def __init__(
        self,
        scenario: BraceScenario,
        uses: tuple[Use, ...] = (),
        seed: int | None = 0,
    ):
        """Builds the plant of a checked scenario.

        Args:
            scenario: In task space, its pads linear or none.
            uses: Effects with their parameter vectors.
            seed: Of the instruments' noise; None: exact readings.

        Raises:
            ScenarioError: Legs or contact that only the diagram has.
            EffectError: Effects that a brace does not take.
        """
        _check_mechanism(scenario)
        plant = _pack_plant(scenario)
        period = 1.0 / scenario.control.rate
        geometry, weights = pack_brace(scenario).geometry, plant.rings[:, 4]
        super().__init__(
            plant,
            PlantTiming(period, round(period / scenario.time_step)),
            tuple(holding_leg_forces(geometry, weights).tolist()),
            stack_laws(uses),
            scenario.torso.present,
            seed,
        )


def _check_mechanism(scenario: BraceScenario) -> None:
    """Refuses what has no compiled law."""
    if scenario.mechanism != "task_space":
        raise ScenarioError(
            f"mechanism is {scenario.mechanism!r}; allowed for an emulated"
            " brace: 'task_space'"
        )
    for ring, contact in zip(scenario.rings, scenario.contacts, strict=True):
        if contact.model == "hydroelastic":
            raise ScenarioError(
                f"contact.{ring}.model is {contact.model!r}; allowed for an"
                " emulated brace: 'linear' or 'none'"
            )


def _pack_plant(scenario: BraceScenario) -> PlantNumbers:
    numbers, torso = pack_brace(scenario), scenario.torso
    geometry, n = numbers.geometry, numbers.num_stages
    start = np.empty((n, 7))
    place_rings(numbers.start, geometry.rest, start)
    return PlantNumbers(
        lower=np.ascontiguousarray(geometry.lower),
        upper=np.ascontiguousarray(geometry.upper),
        rest=geometry.rest,
        start=start,
        torso_rest=numbers.torso_rest,
        viscous=numbers.viscous,
        contact=numbers.contact,
        posture=numbers.posture,
        rings=np.tile(numbers.ring, (n, 1)),
        torso=np.array([torso.mass, *torso.inertia, 0.0]),
        resolution=numbers.resolution,
        noise_sigma=numbers.noise_sigma,
    )

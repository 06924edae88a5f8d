"""A brace of several stages, in task space, as an emulated plant."""

from __future__ import annotations

from brace_drake.core.errors import ScenarioError
from brace_drake.effects.stack import Use
from brace_drake.link.emulator.plant import EmulatedPlant
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace


class BracePlant(EmulatedPlant):
    """Rings, torso, legs and instruments of a brace.

    The compiled laws of the diagram (`brace_drake.model.brace_station`), with
    the stages that the scenario picks.

    Effects act on every stage alike, on the torso once.
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
            EffectError: More effects than it carries.
        """
        _check_mechanism(scenario)
        numbers, present = pack_brace(scenario), scenario.torso.present
        super().__init__(numbers, scenario.time_step, uses, present, seed)


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

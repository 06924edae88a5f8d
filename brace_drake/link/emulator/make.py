"""The emulated plant of any scenario that a device on the link may have."""

from __future__ import annotations

from brace_drake.effects.stack import Use
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.brace_plant import BracePlant
from brace_drake.link.emulator.plant import EmulatedPlant
from brace_drake.scenario.brace import BenchScenario, BraceScenario


def MakePlant(
    scenario: BraceScenario,
    uses: tuple[Use, ...] = (),
    seed: int | None = 0,
) -> EmulatedPlant:
    """The plant of a checked scenario, see `BenchPlant` and `BracePlant`.

    Args:
        scenario: Of the bench, or of a brace in task space.
        uses: Effects beside those of the scenario.
        seed: Of the instruments' noise; None: exact readings.

    Raises:
        ScenarioError, EffectError: What has no compiled law.
    """
    if isinstance(scenario, BenchScenario):
        return BenchPlant(scenario, uses, seed=seed)
    return BracePlant(scenario, uses, seed)

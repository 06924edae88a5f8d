"""A bench whose numbers are off by draws within their tolerances."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.devices.bench.tolerances import KEYS
from brace_drake.effects.stack import Use
from brace_drake.effects.within_tolerances import (
    ANCHORS,
    NUMBERS,
    WITHIN_TOLERANCES,
)
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.effects import scenario_uses
from brace_drake.scenario.fields import fail

# A stream of its own: noise of the same seed is another.
_STREAM = 0x701


def draw_tolerances(
    scenario: BraceScenario, seed: int, source: str = "scenario"
) -> dict[str, float]:
    """By how much each number of a real bench is off, drawn from its prior.

    Normal around 0; dry friction is the upper half of that, delay its
    tolerance or none. A number's draw does not depend on others' tolerances.

    Args:
        scenario: Of one moving ring, legs as forces.
        seed: Of the draws.
        source: Named in errors, such as a file.

    Returns:
        SI units, by the names that `bench_tolerances` has.

    Raises:
        ScenarioError: More than one ring moves, legs are bodies, or a number
            is drawn that no machine can have.
    """
    if len(scenario.stages) != 1:
        allowed = "one stage, as tolerances are drawn for"
        fail(source, "stages", scenario.stages, allowed)
    if scenario.mechanism != "task_space":
        allowed = "task_space, as tolerances are drawn for"
        fail(source, "mechanism", scenario.mechanism, allowed)
    own = scenario.tolerances
    generator = np.random.default_rng([seed, _STREAM])
    normal = generator.standard_normal(len(NUMBERS) + len(ANCHORS.parameters))
    mass, viscous, dry, scale, bias, delay, *anchors = normal.tolist()
    least = -scenario.leg.viscous  # legs do not push by themselves
    drawn = {
        "ring_mass_kg": own.ring_mass * mass,
        "leg_viscous_N_s_m": max(own.leg_viscous * viscous, least),
        "leg_dry_friction_N": own.leg_dry_friction * abs(dry),
        "force_scale": own.force_scale * scale,
        "force_bias_N": own.force_bias * bias,
        "command_delay_s": own.command_delay * (delay > 0.0),
    }
    _check(scenario, drawn, seed, source)
    names = ANCHORS.parameter_names
    return drawn | {
        name: own.anchor * z for name, z in zip(names, anchors, strict=True)
    }


def _check(
    scenario: BraceScenario, drawn: Mapping[str, float], seed: int, source: str
) -> None:
    """Refuses what an effect cannot be, and a ring without mass."""
    for name, value in drawn.items():
        parameter = NUMBERS[name].parameters[0]
        least = parameter.lower
        if name == "ring_mass_kg":
            least = max(least, -scenario.ring.mass)
        if not least < value < parameter.upper and value != 0.0:
            own = getattr(scenario.tolerances, KEYS[name])
            within = f"{least:g} to {parameter.upper:g} {parameter.unit}"
            allowed = f"less: seed {seed} draws {value:.3g}, not {within}"
            fail(source, f"tolerances.{KEYS[name]}", own, allowed)


def uses_of_draws(
    scenario: BraceScenario,
    drawn: Mapping[str, float],
    source: str = "scenario",
) -> tuple[Use, ...]:
    """Effects of a machine that is off by draws; the controller counts with
    the scenario's numbers.

    Args:
        scenario: Whose own effects have to leave a place.
        drawn: From `draw_tolerances`.
        source: Named in errors, such as a file.

    Returns:
        One effect; none where all is exact.

    Raises:
        ScenarioError: The scenario carries as many effects as a twin can.
    """
    if not any(drawn.values()):
        return ()
    if len(scenario.effects) >= MAX_EFFECTS:
        names = [use.name for use in scenario.effects]
        allowed = f"at most {MAX_EFFECTS - 1} beside drawn tolerances"
        fail(source, "effects", names, allowed)
    values = [drawn[name] for name in (*NUMBERS, *ANCHORS.parameter_names)]
    return ((WITHIN_TOLERANCES, np.array(values)),)


def describe_draws(scenario: BraceScenario, drawn: Mapping[str, float]) -> dict:
    """What a machine is made with: its effects and draws, as a label.

    Returns:
        `effects`, `blocks`, `parameters` of the scenario's effects, and
        `within_tolerances`, which has the anchors' spread too.
    """
    cards = [card for card, _ in scenario_uses(scenario)]
    parameters: dict[str, float] = {}
    for use in scenario.effects:
        parameters |= use.parameters
    return {
        "effects": [card.name for card in cards],
        "blocks": sorted({card.block for card in cards}),
        "parameters": parameters,
        "within_tolerances": {
            **{name: drawn[name] for name in NUMBERS},
            "anchor_spread_m": scenario.tolerances.anchor,
            **{name: drawn[name] for name in ANCHORS.parameter_names},
        },
    }

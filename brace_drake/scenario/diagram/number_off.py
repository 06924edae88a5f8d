"""A number of a diagram that is off within its tolerance."""

from __future__ import annotations

from functools import partial

from brace_drake.effects.card import Effect, EffectParameter

_MOST = 10.0


def _move(numbers, values, name: str):
    return numbers.with_number_off(name, float(values[0]))


def number_off(name: str, deviation: float) -> Effect:
    """The card of a number that is off, in its own unit.

    Args:
        name: Of the number.
        deviation: One standard deviation of what it may be off.
    """
    return Effect(
        name=f"{name}_off",
        block="mechanism",
        title=f"{name.replace('_', ' ')} off within its tolerance",
        equation=f"{name} = nominal + e",
        source="the scenario's tolerances",
        parameters=(
            EffectParameter(
                "off",
                "1",
                -_MOST * deviation,
                _MOST * deviation,
                (deviation,),
                "error e",
                deviation=deviation,
            ),
        ),
        modify=partial(_move, name=name),
        signature="small",
        impostors={},
        experiment="none",
    )

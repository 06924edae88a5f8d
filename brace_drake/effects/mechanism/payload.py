"""A mass on a body that the nominal model does not have."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from brace_drake.effects.card import Effect, EffectParameter

# Of the body's own mass, and of how far its centre is from its frame.
_MOST, _FARTHEST = 5.0, 3.0


def _load(numbers, values, body: str):
    return numbers.with_payload(body, float(values[0]), float(values[1]))


def _parameters(mass: float, reach: float) -> tuple[EffectParameter, ...]:
    return (
        EffectParameter(
            "payload_kg",
            "kg",
            -0.9 * mass,
            _MOST * mass,
            (0.05 * mass, 0.2 * mass),
            "mass m",
        ),
        EffectParameter(
            "distance_m",
            "m",
            0.0,
            _FARTHEST * reach,
            (reach, 2.0 * reach),
            "distance r from the body's frame",
            off=None,
        ),
    )


# Of a body of 1 kg whose centre is 1 m from its frame.
CARD = Effect(
    name="payload",
    block="mechanism",
    title="a mass more than nominal",
    equation="M = M_nominal + m at the distance r",
    source="Craig, Introduction to Robotics, section 6.3",
    parameters=_parameters(1.0, 1.0),
    modify=partial(_load, body=""),
    needs=("body of a plant",),
    signature="weight and inertia together, in proportion",
    impostors={
        "unbalanced_weight": "a weight without its inertia",
        "command_gain": "in proportion to the command, not to the motion",
    },
    remedy="weigh what the body carries and find where it sits; write"
    " both into the scenario",
    experiment="slow and fast strokes over a wide way",
)


def payload_card(body: str, mass: float, reach: float) -> Effect:
    """The card of a point mass on a body, on the line from the body's frame
    through its centre of mass.

    Args:
        body: Its name.
        mass: Its own mass, kg.
        reach: How far its centre is from its frame, m.
    """
    return replace(
        CARD,
        at=body,
        title=f"{CARD.title}: {body.replace('_', ' ')}",
        parameters=_parameters(mass, reach),
        modify=partial(_load, body=body),
    )

"""The library's effects as one axis has them: in its units, for its inputs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.registry import effects_for
from brace_drake.recording.columns import split_unit
from brace_drake.scenario.axis.signal_card import ramp_card, signal_card
from brace_drake.scenario.axis.units import (
    AxisUnits,
    input_unit,
    scales,
    with_few_starts,
)

# Places that an axis has which follows a command.
COMMANDED = "axis under command"
# Places of one whose motor was measured too.
BEHIND_MOTOR = "axis behind a motor"
# What a follower has by its own numbers: its bias or offset, its limits.
_OF_A_FOLLOWER = {"command_offset", "saturation", "sensor_offset"}
# What a limit of the rate of a command limits of the motion, by its unit.
_RAMPS = {
    "m_s": "acceleration_limit",
    "rad_s": "acceleration_limit",
    "m": "speed_limit",
    "rad": "speed_limit",
}
# Unit of a parameter that is for each unit of an extra input.
_OF_INPUT = "/input"


@dataclass(frozen=True)
class OwnCard:
    """A card in the units of an axis.

    Attributes:
        card: With names, limits and starts in SI.
        unit: Value in SI of each parameter's unit of reference (n,).
        behind: What its laws are given behind the parameters: the place of
            the extra input that they take, or what angles are counted in.
    """

    card: Effect
    unit: np.ndarray
    behind: tuple[float, ...] = ()

    def of_reference(self, values: np.ndarray) -> np.ndarray:
        """The laws' parameters from those in SI."""
        return np.array([*(values / self.unit), *self.behind])


@cache
def own_cards(
    device: str,
    units: AxisUnits,
    ranges: AxisUnits,
    inputs: tuple[str, ...],
    sizes: tuple[float, ...],
    signal: tuple[str, float] = ("", 1.0),
) -> dict[str, OwnCard]:
    """Cards of an axis by key; those that take a load once for each input.

    Args:
        device: AXIS, COMMANDED or BEHIND_MOTOR.
        units: Of the axis.
        ranges: Units with the sizes that limits and starts go by.
        inputs: Columns of its extra inputs.
        sizes: What each of these is counted in.
        signal: Column of the command that it follows, or of the load's
            reading behind a motor, and half of its range.
    """
    found: dict[str, OwnCard] = {}
    for effect in effects_for(device).values():
        if "signal" in effect.laws:
            # What the drive's own feedback sees comes before.
            if effect.name not in {*found, *_OF_A_FOLLOWER}:
                card, unit = signal_card(effect, *signal)
                limit = _limited_by(card, signal[0], found)
                card = card if limit is None else ramp_card(limit, card)
                found[card.key] = OwnCard(card, unit)
            continue
        card, unit = ranges.card(effect), scales(effect, units)
        if device in (COMMANDED, BEHIND_MOTOR) and "drive" in card.laws:
            card = with_few_starts(card)
        if "angle" in effect.places:
            if units.is_rotary:
                found[card.key] = OwnCard(card, unit, (units.length,))
            continue
        if "extra input" not in effect.places:
            found[card.key] = OwnCard(card, unit)
            continue
        for own in _of_inputs(card, unit, inputs, sizes):
            found[own.card.key] = own
    return found


def _limited_by(
    card: Effect, column: str, found: Mapping[str, OwnCard]
) -> Effect | None:
    """Of what a card is the ramp, where it is one."""
    if card.name != "rate_limit":
        return None
    known = found.get(_RAMPS.get(split_unit(column)[1], ""))
    return None if known is None else known.card


def _of_inputs(card, unit, inputs, sizes) -> Iterator[OwnCard]:
    is_own = np.array([p.unit.endswith(_OF_INPUT) for p in card.parameters])
    for place, (name, size) in enumerate(zip(inputs, sizes, strict=True)):
        quantity, of_input = input_unit(name)
        quantity = quantity.replace("_", " ")
        parameters = tuple(
            _for_each(p, of_input, size) if own else p
            for p, own in zip(card.parameters, is_own, strict=True)
        )
        mine = replace(
            card,
            form=", ".join(filter(None, (card.form, quantity))),
            title=f"{card.title}: {quantity}",
            parameters=parameters,
        )
        yield OwnCard(mine, unit / np.where(is_own, size, 1.0), (float(place),))


def _for_each(
    parameter: EffectParameter, of_input: str, size: float
) -> EffectParameter:
    """A parameter for each unit of an input that is counted in a size."""
    return replace(
        parameter,
        name=parameter.name.removesuffix("_input")
        + "_"
        + of_input.replace(" ", "_"),
        unit=parameter.unit.replace("input", f"({of_input})"),
        lower=parameter.lower / size,
        upper=parameter.upper / size,
        starts=tuple(s / size for s in parameter.starts),
    )

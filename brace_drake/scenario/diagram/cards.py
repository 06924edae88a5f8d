"""The library's effects at the ports, joints and bodies of a diagram."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.mechanism.payload import payload_card
from brace_drake.effects.registry import effects_for
from brace_drake.effects.signal.ways import COMMAND, READING
from brace_drake.recording.columns import shown_unit, split_unit
from brace_drake.scenario.axis.signal_card import signal_card
from brace_drake.scenario.axis.units import (
    FORCE_N,
    LENGTH_M,
    AxisUnits,
    scales,
    with_few_starts,
)
from brace_drake.scenario.diagram.number_off import number_off

# Places of `effects.registry.PLACES`, beside those of a port.
JOINT, BODY, NUMBER = "joint of a plant", "body", "number"
_IMPOSED = "joint that is moved"


@dataclass(frozen=True)
class PlacedCard:
    """A card at one place of a diagram.

    Attributes:
        card: In the units of its place, which its form names.
        place: COMMAND, READING, JOINT, BODY or NUMBER.
        target: Column, joint, body or number.
        unit: Value of each parameter's unit of reference (n,).
        behind: What its laws are given behind the parameters.
    """

    card: Effect
    place: str
    target: str
    unit: np.ndarray
    behind: tuple[float, ...] = ()

    @property
    def is_tolerance(self) -> bool:
        """Whether it is a number off within its tolerance, no finding."""
        return self.place == NUMBER

    def of_reference(self, values: np.ndarray) -> np.ndarray:
        """The law's parameters from those in SI."""
        return np.array([*(values / self.unit), *self.behind])


@cache
def place_cards(
    commands, readings, joints, bodies, deviations, is_imposed=False
) -> dict[str, PlacedCard]:
    """Cards of a diagram by key.

    Args:
        commands, readings: (column, half of its range) of each.
        joints: (name, kind, half of its travel, force) of each.
        bodies: (name, mass, kg, reach, m) of each.
        deviations: (number, one standard deviation) of each.
        is_imposed: Whether joints are moved as they were recorded.
    """
    found = []
    for way, signals in ((COMMAND, commands), (READING, readings)):
        quantities = [split_unit(name)[0] for name, _ in signals]
        for (name, size), quantity in zip(signals, quantities, strict=True):
            # A position and its speed may be the same but for the unit.
            own = quantity if quantities.count(quantity) == 1 else name
            found += _of_signal(way, name, own, size)
    way = _IMPOSED if is_imposed else JOINT
    found += [p for joint in joints for p in _of_joint(way, *joint)]
    for name, mass, reach in bodies:
        card = payload_card(name, mass, reach)
        found.append(PlacedCard(card, BODY, name, np.ones(2)))
    for name, deviation in deviations:
        card = number_off(name, deviation)
        found.append(PlacedCard(card, NUMBER, name, np.ones(1)))
    return {placed.card.key: placed for placed in found}


def _of_signal(
    way: str, column: str, form: str, size: float
) -> Iterator[PlacedCard]:
    for effect in effects_for(way).values():
        card, sizes = signal_card(effect, column, size)
        yield PlacedCard(_placed(card, form), way, column, sizes)


def _of_joint(
    way: str, name: str, kind: str, travel: float, force: float
) -> Iterator[PlacedCard]:
    units = AxisUnits(travel / LENGTH_M, force / FORCE_N, kind == "rotary")
    known: set[str] = set()
    cards = effects_for(way).values()
    for effect in sorted(cards, key=lambda e: "imposed motion" not in e.places):
        # The first form of those that a joint cannot tell apart.
        if effect.name in known:
            continue
        known.add(effect.name)
        is_turned = "angle" in effect.places
        if is_turned and not units.is_rotary:
            continue
        behind = (units.length,) if is_turned else ()
        card = with_few_starts(units.card(effect))
        yield PlacedCard(
            _placed(card, name),
            JOINT,
            name,
            scales(effect, units),
            behind,
        )


def _placed(effect: Effect, target: str) -> Effect:
    quantity, unit = split_unit(target)
    place = quantity.replace("_", " ") + (f" ({shown_unit(unit)})" * bool(unit))
    return replace(effect, form="", at=target, title=f"{effect.title}: {place}")

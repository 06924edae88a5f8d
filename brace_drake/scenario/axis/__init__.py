"""One axis by its numbers, in the units of its own size."""

from brace_drake.scenario.axis.cards import OwnCard, own_cards
from brace_drake.scenario.axis.numbers import (
    AxisNumbers,
    AxisScenario,
    pack_axis,
)
from brace_drake.scenario.axis.units import AxisUnits, input_unit

__all__ = [
    "AxisNumbers",
    "AxisScenario",
    "AxisUnits",
    "OwnCard",
    "input_unit",
    "own_cards",
    "pack_axis",
]

"""A machine that is any Drake diagram: its ports, numbers and effects."""

from brace_drake.scenario.diagram.cards import PlacedCard
from brace_drake.scenario.diagram.numbers import (
    BodySizes,
    DiagramScenario,
    JointSizes,
)

__all__ = ["BodySizes", "DiagramScenario", "JointSizes", "PlacedCard"]

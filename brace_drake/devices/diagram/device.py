"""Any machine that a Drake diagram models, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.devices.declaration import (
    BlockTest,
    Device,
    MotionSignals,
    Nuisance,
)
from brace_drake.devices.diagram.factory import MakeDiagram
from brace_drake.devices.diagram.imposed import ImposedTwin
from brace_drake.devices.diagram.nominal import MakeDiagramScenario
from brace_drake.devices.diagram.twin import DiagramTwin
from brace_drake.devices.motions.library import MotionSet
from brace_drake.recording.columns import DIAGRAM, shown_unit, split_unit
from brace_drake.recording.recording import Campaign, Run


class DiagramDevice(Device):
    """Device of campaigns that state `device: diagram`."""

    def __init__(
        self,
        campaign: Campaign,
        scenario=None,
        make: MakeDiagram | None = None,
    ):
        if make is None:
            raise ScenarioError(
                f"{campaign.path}: recorded on a {DIAGRAM}: name the function"
                " that makes it, as in --diagram arm.py:MakeArm"
            )
        name = f"{make.__module__}:{getattr(make, '__qualname__', 'diagram')}"
        scenario = scenario or MakeDiagramScenario(campaign, make, name)
        way = ImposedTwin if scenario.is_imposed else DiagramTwin
        twin = way(scenario, make)
        tests: list[BlockTest] = []
        super().__init__(twin, campaign.rate_hz, tests)
        self.words = MappingProxyType(_words(_outputs(scenario)))

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """Each output port, where its elements are of one unit."""
        found, end = {}, 0
        names = _outputs(self.twin.scenario)
        units = [_unit(columns) for columns in names.values()]
        for (port, columns), unit in zip(names.items(), units, strict=True):
            begin, end = end, end + len(columns)
            if unit is not None:
                found[f"{port}_error"] = x[:, begin:end]
        return found

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """The first reading, of no force is known that it goes along it; of an
        imposed motion the first joint whose force was read.
        """
        scenario = self.twin.scenario
        if scenario.is_imposed:
            joint = next(iter(scenario.forces))
            way = prepared.run.channels[scenario.imposed[joint]]
            return MotionSignals(way, 0, None, way, joint.replace("_", " "))
        way = prepared.measured[:, 0]
        name = split_unit(self.twin.channels[0])[0].replace("_", " ")
        return MotionSignals(way, None, None, way, name)

    def motions(self, runs: Sequence[Run]) -> MotionSet | None:
        """None: what the machine may be asked for is not known."""
        return None

    def tolerances(self) -> list[Nuisance]:
        """Of the numbers that its campaign states `deviations` of."""
        found = []
        for placed in self.twin.scenario.placed_cards().values():
            if placed.is_tolerance:
                deviation = self.twin.scenario.deviations[placed.target]
                unit = shown_unit(split_unit(placed.target)[1]) or "1"
                uses = ((placed.card, np.array([deviation])),)
                block = placed.card.block
                found.append(
                    Nuisance(placed.target, unit, block, deviation, uses)
                )
        return found


def _outputs(scenario) -> dict[str, list[str]]:
    """Columns of each output port; of an imposed motion of each joint."""
    of_joints = {joint: [column] for joint, column in scenario.forces.items()}
    return scenario.outputs or of_joints


def _unit(columns: Sequence[str]) -> str | None:
    """The unit that columns share, None where they have several."""
    units = {split_unit(column)[1] for column in columns}
    return shown_unit(units.pop()) if len(units) == 1 else None


def _words(outputs) -> dict[str, tuple[str, str]]:
    """Title and unit of each port that is of one unit."""
    return {
        f"{port}_error": (port.replace("_", " ").capitalize(), _unit(columns))
        for port, columns in outputs.items()
        if _unit(columns) is not None
    }

"""The diagram of a scenario as it is drawn: its nominal run, at rest."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Diagram
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.devices.leg_bench.twin import LegMotion
from brace_drake.model.articulated import GetClosures
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.leg_station import MakeLegBenchStation
from brace_drake.model.pad_station import MakePadBenchStation
from brace_drake.model.station import MakeBenchStation
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings
from brace_drake.scenario.leg_bench import LegBenchScenario, pack_leg_bench
from brace_drake.scenario.load import Scenario
from brace_drake.scenario.pad_bench import PadBenchScenario, pack_pad_bench


def MakeDrawnDiagram(
    scenario: Scenario,
) -> tuple[Diagram, MultibodyPlant | None, list[tuple[RigidBody, RigidBody]]]:
    """The diagram of any scenario, with a reference that stays at rest.

    Returns:
        The diagram; its plant, where it has one; and pairs of bodies that
        constraints hold together.
    """
    if isinstance(scenario, BraceScenario):
        controller = MakeController(scenario.control, pack_rings(scenario))
        station = MakeBraceStation(scenario, controller)
        plant, closures = station.plant, []
        if scenario.mechanism == "articulated":
            closures = GetClosures(plant, scenario)
        return station.diagram, plant, closures
    if isinstance(scenario, BenchScenario):
        rest = PiecewisePolynomial(np.zeros((3, 1)))
        station = MakeBenchStation(scenario, rest)
    elif isinstance(scenario, LegBenchScenario):
        rest = LegMotion(np.zeros((2, 3)), np.zeros(2), np.zeros(2), True)
        numbers = pack_leg_bench(scenario)
        station = MakeLegBenchStation(numbers, rest, scenario.time_step)
    elif isinstance(scenario, PadBenchScenario):
        numbers, step = pack_pad_bench(scenario), scenario.time_step
        time = step * np.arange(3)
        station = MakePadBenchStation(numbers, time, np.zeros((3, 2)), step)
        return station.diagram, None, []
    else:
        raise TypeError(f"no diagram of a {type(scenario).__name__}")
    return station.diagram, station.plant, []

"""The bench as a Drake diagram with ports named by role."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    Demultiplexer,
    LogVectorOutput,
    TrajectorySource,
    VectorLogSink,
)
from pydrake.trajectories import Trajectory

from brace_drake.laws.plug_in import PlugIn
from brace_drake.plant import AddBenchPlant
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_numbers import BenchNumbers, pack_bench
from brace_drake.systems.bench_forces import BenchForces
from brace_drake.systems.controller_blocks import (
    BraceInverseDynamics,
    ImpedanceFilter,
    PoseEstimator,
    TickHold,
)
from brace_drake.systems.instruments import BenchInstruments
from brace_drake.systems.pic_controller import PicController


@dataclass
class BenchStation:
    """A built bench: the diagram and the parts that callers reach for.

    Exported ports of the diagram: input `noise` (12,), standard normal draws
    that hold for a control tick (unconnected: exact readings); outputs
    `plant_state` and, of the last tick, `leg_command` (6,), `readings` (12,)
    and `memory` of the controller, which ends in the filtered force and the
    virtual position, velocity, acceleration.
    """

    diagram: Diagram
    plant: MultibodyPlant
    sinks: dict[str, VectorLogSink]


def MakeBenchStation(
    scenario: BenchScenario,
    reference: Trajectory,
    plug_ins: Mapping[str, PlugIn] | None = None,
    numbers: BenchNumbers | None = None,
) -> BenchStation:
    """Builds the bench of a scenario that follows a reference.

    Args:
        scenario: Numbers of the nominal twin.
        reference: y_d, y_d', y_d'' as a trajectory of three rows.
        plug_ins: Effects by plug point.
        numbers: The scenario's numbers as effects have changed them.
    """
    plug_ins = plug_ins or {}
    numbers = numbers or pack_bench(scenario)
    builder = DiagramBuilder()
    # Bodies, and the forces on them.
    plant = AddBenchPlant(builder, scenario)
    forces = _AddForces(builder, plant, scenario, numbers, plug_ins)
    # What the instruments read.
    instruments = builder.AddNamedSystem(
        "instruments", BenchInstruments(numbers, plug_ins)
    )
    measured = forces.GetOutputPort("measured")
    builder.Connect(measured, instruments.GetInputPort("measured"))
    readings = instruments.GetOutputPort("readings")
    # Reference and controller.
    source = builder.AddNamedSystem("reference", TrajectorySource(reference))
    add = _CONTROLLERS[scenario.control.layout]
    ports = add(builder, readings, source.get_output_port(), numbers)
    command = ports["leg_command"]
    builder.Connect(command, forces.GetInputPort("leg_command"))
    builder.Connect(command, instruments.GetInputPort("previous_command"))
    # Ports and logs.
    builder.ExportInput(instruments.GetInputPort("noise"), "noise")
    builder.ExportOutput(plant.get_state_output_port(), "plant_state")
    sinks = {}
    for name, port in ports.items():
        builder.ExportOutput(port, name)
        sinks[name] = LogVectorOutput(
            port, builder, scenario.sensors.log_period
        )
    diagram = builder.Build()
    diagram.set_name("bench_station")
    return BenchStation(diagram, plant, sinks)


def _AddForces(builder, plant, scenario, numbers, plug_ins) -> BenchForces:
    """Adds legs, posture and pads and connects them with the plant."""
    forces = builder.AddNamedSystem(
        "forces",
        BenchForces(
            numbers,
            plug_ins,
            plant.time_step(),
            with_torso=scenario.torso.present,
            with_pads=scenario.torso.present
            and scenario.contact.model == "linear",
        ),
    )
    builder.Connect(
        plant.get_state_output_port(), forces.GetInputPort("plant_state")
    )
    builder.Connect(
        forces.GetOutputPort("generalized_force"),
        plant.get_applied_generalized_force_input_port(),
    )
    return forces


def _AddPicController(builder, readings, desired, numbers):
    """Adds the controller as one system; returns its ports by role."""
    pic = builder.AddNamedSystem("pic_controller", PicController(numbers))
    builder.Connect(readings, pic.GetInputPort("readings"))
    builder.Connect(desired, pic.GetInputPort("desired"))
    roles = ("leg_command", "readings", "memory")
    return {role: pic.GetOutputPort(role) for role in roles}


def _AddControllerBlocks(builder, readings, desired, numbers):
    """Adds the controller block by block; returns its ports by role."""
    split = builder.AddNamedSystem(
        "readings_split", Demultiplexer(np.array([6, 3, 3]))
    )
    estimator = builder.AddNamedSystem(
        "pose_estimator", PoseEstimator(numbers)
    )
    impedance = builder.AddNamedSystem(
        "impedance_filter", ImpedanceFilter(numbers)
    )
    dynamics = builder.AddNamedSystem(
        "inverse_dynamics", BraceInverseDynamics(numbers)
    )
    hold = builder.AddNamedSystem(
        "tick_hold", TickHold(numbers.estimator[3])
    )
    for source, target in (
        (readings, split.get_input_port()),
        (split.get_output_port(0), estimator.GetInputPort("leg_length")),
        (split.get_output_port(1), impedance.GetInputPort("force")),
        (desired, impedance.GetInputPort("desired")),
        (
            estimator.GetOutputPort("estimated_state"),
            dynamics.GetInputPort("estimated_state"),
        ),
        (
            impedance.GetOutputPort("virtual"),
            dynamics.GetInputPort("virtual"),
        ),
        (dynamics.GetOutputPort("command"), hold.GetInputPort("command")),
        (readings, hold.GetInputPort("readings")),
    ):
        builder.Connect(source, target)
    return {
        "leg_command": hold.GetOutputPort("leg_command"),
        "readings": hold.GetOutputPort("readings"),
        "memory": impedance.GetOutputPort("held_virtual"),
    }


_CONTROLLERS = {"pic": _AddPicController, "blocks": _AddControllerBlocks}

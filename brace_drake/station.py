"""The bench as a Drake diagram with ports named by role."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    Adder,
    ConstantVectorSource,
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
from brace_drake.systems.controller import (
    BraceInverseDynamics,
    CommandHold,
    ImpedanceFilter,
    PoseEstimator,
)
from brace_drake.systems.instruments import BenchInstruments
from brace_drake.systems.leg_drives import LegDrives
from brace_drake.systems.torso_interaction import TorsoInteraction


@dataclass
class BenchStation:
    """A built bench: the diagram and the parts that callers reach for.

    Exported ports of the diagram: input `noise` (12,), standard normal draws
    that hold for a control tick (unconnected: exact readings); outputs
    `leg_command`, `readings`, `virtual`, `plant_state`.
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
    # Bodies.
    plant = AddBenchPlant(builder, scenario)
    state = plant.get_state_output_port()
    # Forces on them.
    legs, pad_force = _AddForces(builder, plant, scenario, numbers, plug_ins)
    # What the instruments read.
    instruments = builder.AddNamedSystem(
        "instruments",
        BenchInstruments(numbers, plug_ins, scenario.torso.present),
    )
    builder.Connect(
        legs.GetOutputPort("length"), instruments.GetInputPort("leg_length")
    )
    builder.Connect(pad_force, instruments.GetInputPort("pad_force"))
    builder.Connect(state, instruments.GetInputPort("plant_state"))
    # Reference and controller.
    command, held, virtual = _AddController(
        builder, instruments, numbers, reference
    )
    builder.Connect(held, legs.GetInputPort("command"))
    builder.Connect(held, instruments.GetInputPort("held_command"))
    # Ports and logs.
    builder.ExportInput(instruments.GetInputPort("noise"), "noise")
    outputs = {
        "leg_command": command,
        "readings": instruments.GetOutputPort("readings"),
        "virtual": virtual,
    }
    sinks = {}
    for name, port in outputs.items():
        builder.ExportOutput(port, name)
        sinks[name] = LogVectorOutput(
            port, builder, scenario.sensors.log_period
        )
    builder.ExportOutput(state, "plant_state")
    diagram = builder.Build()
    diagram.set_name("bench_station")
    return BenchStation(diagram, plant, sinks)


def _AddForces(builder, plant, scenario, numbers, plug_ins):
    """Adds legs and torso interaction; returns the legs and the pad force."""
    with_torso = scenario.torso.present
    step = plant.time_step()
    legs = builder.AddNamedSystem(
        "legs", LegDrives(numbers, plug_ins, step, with_torso)
    )
    state = plant.get_state_output_port()
    builder.Connect(state, legs.GetInputPort("plant_state"))
    applied = plant.get_applied_generalized_force_input_port()
    if not with_torso:
        builder.Connect(legs.GetOutputPort("generalized_force"), applied)
        none = builder.AddNamedSystem(
            "no_pad_force", ConstantVectorSource(np.zeros(3))
        )
        return legs, none.get_output_port()
    interaction = builder.AddNamedSystem(
        "torso_interaction",
        TorsoInteraction(numbers, plug_ins, step, with_contact=True),
    )
    builder.Connect(state, interaction.GetInputPort("plant_state"))
    total = builder.AddNamedSystem("generalized_force", Adder(2, 12))
    for i, system in enumerate((legs, interaction)):
        builder.Connect(
            system.GetOutputPort("generalized_force"), total.get_input_port(i)
        )
    builder.Connect(total.get_output_port(), applied)
    return legs, interaction.GetOutputPort("pad_force")


def _AddController(builder, instruments, numbers, reference):
    """Adds the controller; returns command, held command, virtual ports."""
    split = builder.AddNamedSystem(
        "readings_split", Demultiplexer(np.array([6, 3, 3]))
    )
    source = builder.AddNamedSystem("reference", TrajectorySource(reference))
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
        "command_hold", CommandHold(numbers.estimator[3])
    )
    builder.Connect(instruments.GetOutputPort("readings"), split.get_input_port())
    builder.Connect(split.get_output_port(0), estimator.GetInputPort("leg_length"))
    builder.Connect(split.get_output_port(1), impedance.GetInputPort("force"))
    builder.Connect(source.get_output_port(), impedance.GetInputPort("desired"))
    builder.Connect(
        estimator.GetOutputPort("estimated_state"),
        dynamics.GetInputPort("estimated_state"),
    )
    builder.Connect(
        impedance.GetOutputPort("virtual"), dynamics.GetInputPort("virtual")
    )
    command = dynamics.GetOutputPort("command")
    builder.Connect(command, hold.GetInputPort("command"))
    held = hold.GetOutputPort("held_command")
    return command, held, impedance.GetOutputPort("virtual")

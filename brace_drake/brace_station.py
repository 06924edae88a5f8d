"""The whole brace as a Drake diagram with ports named by role."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
    System,
)
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    LogVectorOutput,
    Multiplexer,
    Saturation,
    TrajectorySource,
    VectorLogSink,
)
from pydrake.trajectories import Trajectory

from brace_drake.brace_plant import (
    AddBracePlant,
    AddGeometry,
    plant_resolves_contact,
)
from brace_drake.effects.stack import Use, stack_laws
from brace_drake.errors import ScenarioError
from brace_drake.laws.plug_in import PlugIn
from brace_drake.plant import AddStateLog
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import BraceNumbers, pack_brace
from brace_drake.systems.brace_forces import BraceForces, ConnectBraceForces
from brace_drake.systems.contact_force_hold import AddContactForce
from brace_drake.systems.instruments import BraceInstruments


@dataclass
class BraceStation:
    """A built brace of S stages: the diagram and parts that callers reach for.

    Exported ports of the diagram, arrays bottom to top. Inputs: `leg_command`
    (6 S,), N, where there is no controller; else those of the controller's
    inputs `desired` (18 S,) and `stiffness` (6 S,) that it has and nothing
    feeds; `noise` (9 S + 3,), see BraceInstruments. Outputs: `plant_state`;
    `leg_length` (6 S,), m, and `force` (3 S,), N, as the instruments read
    them; `marker` (3,), m, the torso's displacement; `drive_force` (6 S,), N,
    the commands within the drives' limits; the controller's own.

    `sink` logs drive forces (6 S), leg lengths (6 S), forces (3 S) and marker
    (3) every `log_period`, at a tick; `state_sink` the plant's state.
    """

    diagram: Diagram
    plant: MultibodyPlant
    numbers: BraceNumbers
    sink: VectorLogSink
    state_sink: VectorLogSink


def MakeBraceStation(
    scenario: BraceScenario,
    controller: System | None = None,
    desired: Trajectory | None = None,
    noise: Trajectory | None = None,
    add_geometry: AddGeometry | None = None,
    uses: Sequence[Use] = (),
) -> BraceStation:
    """Builds the brace of a scenario around a controller.

    Args:
        scenario: Checked.
        controller: LeafSystem or Diagram with inputs `leg_length` (6 S,),
            `force` (3 S,), `desired` (18 S,), possibly `stiffness` (6 S,), and
            outputs `leg_command` (6 S,), `virtual` (18 S,), `impedance`
            (18 S,), held from its last tick.
        desired: X_d, X_d', X_d'' (18 S rows), in place of the exported port.
        noise: Standard normal draws (9 S + 3 rows), constant around each
            tick, in place of the exported port.
        add_geometry: See `AddBracePlant`.
        uses: Effects with their parameters, on a brace of one stage whose
            pads are linear; those that change the brace's numbers are not for
            it.

    Raises:
        EffectError: Effects that this brace does not take.
        ScenarioError: The controller's ports are of another number of stages,
            or a ring of the articulated brace is too light for its legs.
    """
    numbers, plug_ins = pack_brace(scenario), stack_laws(uses)
    builder = DiagramBuilder()
    # Bodies, and the forces on them.
    plant = AddBracePlant(builder, scenario, add_geometry)
    forces, drives = _AddForces(builder, plant, scenario, numbers, plug_ins)
    if plant_resolves_contact(scenario):
        AddContactForce(builder, plant, scenario.rings, forces)
    # Drives that give what they can, instruments that read what they see.
    limit = np.full(6 * numbers.num_stages, scenario.leg.force_limit)
    drive = builder.AddNamedSystem("drives", Saturation(-limit, limit))
    for port in drives:
        builder.Connect(drive.get_output_port(), port)
    readings = _AddInstruments(
        builder, scenario, numbers, forces, drive, noise, plug_ins
    )
    # Controller, ports and log.
    if controller is None:
        builder.ExportInput(drive.get_input_port(), "leg_command")
    else:
        _check_ports(controller, numbers.num_stages)
        _ConnectController(builder, controller, readings, drive, desired)
    builder.ExportOutput(plant.get_state_output_port(), "plant_state")
    builder.ExportOutput(drive.get_output_port(), "drive_force")
    for name, port in readings.items():
        builder.ExportOutput(port, name)
    logged = _Join(
        builder, "log_row", [drive.get_output_port(), *readings.values()]
    )
    sink = LogVectorOutput(logged, builder, scenario.sensors.log_period)
    sink.set_name("log")
    state_sink = AddStateLog(builder, plant, scenario.sensors.log_period)
    diagram = builder.Build()
    diagram.set_name("brace_station")
    return BraceStation(diagram, plant, numbers, sink, state_sink)


def _check_ports(controller: System, n: int) -> None:
    """Checks a controller's ports against the stages of the scenario."""
    inputs = {"leg_length": 6 * n, "force": 3 * n, "desired": 18 * n}
    outputs = {"leg_command": 6 * n, "virtual": 18 * n, "impedance": 18 * n}
    for get, sizes in (
        (controller.GetInputPort, inputs),
        (controller.GetOutputPort, outputs),
    ):
        for name, size in sizes.items():
            try:
                found = get(name).size()
            except RuntimeError as error:
                line = " ".join(str(error).split())
                raise ScenarioError(f"controller: {line}") from error
            if found != size:
                raise ScenarioError(
                    f"controller: port {name} has size {found}; allowed:"
                    f" {size}, as the scenario has {n} stages"
                )


def _AddForces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scenario: BraceScenario,
    numbers: BraceNumbers,
    plug_ins: Mapping[str, PlugIn],
) -> tuple[BraceForces, list[InputPort]]:
    """Adds pads, posture and, where they are forces, legs around the plant.

    Returns:
        The system, and the input ports for the legs' forces.
    """
    with_legs = scenario.mechanism == "task_space"
    forces = builder.AddNamedSystem(
        "forces",
        BraceForces(
            numbers.num_stages,
            plant.time_step(),
            scenario.torso.present,
            with_pads=bool(numbers.contact[:, 0:2].any()),
            with_legs=with_legs,
            plug_ins=plug_ins,
        ),
    )
    state = plant.get_state_output_port()
    applied = plant.get_applied_generalized_force_input_port()
    if not with_legs:
        bodies = list(scenario.rings)
        bodies += ["torso"] if scenario.torso.present else []
        state = _GatherState(builder, plant, bodies)
        applied = _ScatterForce(builder, plant, bodies)
    drives = [
        ConnectBraceForces(builder, forces, numbers.force_law, state, applied)
    ]
    if not with_legs:
        drives.append(plant.get_actuation_input_port())
    return forces, drives


def _GatherState(
    builder: DiagramBuilder, plant: MultibodyPlant, bodies: list[str]
) -> OutputPort:
    """q of all bodies, then v of all, out of a plant that has others too."""
    q, v = [], []
    for name in bodies:
        instance = plant.GetModelInstanceByName(name)
        split = builder.AddNamedSystem(f"{name}_state", Demultiplexer([7, 6]))
        state = plant.get_state_output_port(instance)
        builder.Connect(state, split.get_input_port())
        q.append(split.get_output_port(0))
        v.append(split.get_output_port(1))
    return _Join(builder, "bodies_state", [*q, *v])


def _ScatterForce(
    builder: DiagramBuilder, plant: MultibodyPlant, bodies: list[str]
) -> InputPort:
    """The input port for forces on bodies alone; nothing acts on the rest."""
    split = builder.AddNamedSystem(
        "bodies_force", Demultiplexer([6] * len(bodies))
    )
    starts = {
        plant.GetBodyByName(name).floating_velocities_start_in_v(): i
        for i, name in enumerate(bodies)
    }
    blocks, at = [], 0
    for start in [*sorted(starts), plant.num_velocities()]:
        if start > at:
            zeros = ConstantVectorSource(np.zeros(start - at))
            zeros = builder.AddNamedSystem(f"no_force_{at}", zeros)
            blocks.append(zeros.get_output_port())
        if start in starts:
            blocks.append(split.get_output_port(starts[start]))
        at = start + 6
    builder.Connect(
        _Join(builder, "applied_force", blocks),
        plant.get_applied_generalized_force_input_port(),
    )
    return split.get_input_port()


def _AddInstruments(
    builder, scenario, numbers, forces, drive, noise, plug_ins
) -> dict[str, OutputPort]:
    """Adds instruments; without noise they read what is there, exactly."""
    n = numbers.num_stages
    instruments = builder.AddNamedSystem(
        "instruments",
        BraceInstruments(
            numbers.resolution,
            numbers.noise_sigma,
            1.0 / scenario.control.rate,
            plug_ins,
        ),
    )
    for source, port in (
        (forces.GetOutputPort("measured"), "measured"),
        (drive.get_output_port(), "held_command"),
    ):
        builder.Connect(source, instruments.GetInputPort(port))
    _Feed(builder, instruments.GetInputPort("noise"), noise)
    split = builder.AddNamedSystem("readings", Demultiplexer([6 * n, 3 * n, 3]))
    builder.Connect(instruments.get_output_port(), split.get_input_port())
    names = ("leg_length", "force", "marker")
    return {name: split.get_output_port(i) for i, name in enumerate(names)}


def _ConnectController(builder, controller, readings, drive, desired) -> None:
    # In a diagram, a system without a name is given its address as one.
    if not controller.get_name():
        controller.set_name("controller")
    builder.AddSystem(controller)
    for name in ("leg_length", "force"):
        builder.Connect(readings[name], controller.GetInputPort(name))
    _Feed(builder, controller.GetInputPort("desired"), desired)
    if controller.HasInputPort("stiffness"):
        _Feed(builder, controller.GetInputPort("stiffness"), None)
    builder.Connect(
        controller.GetOutputPort("leg_command"), drive.get_input_port()
    )
    for name in ("leg_command", "virtual", "impedance", "estimate"):
        if controller.HasOutputPort(name):
            builder.ExportOutput(controller.GetOutputPort(name), name)


def _Feed(
    builder: DiagramBuilder, port: InputPort, trajectory: Trajectory | None
) -> None:
    """Feeds a port from a trajectory, or exports it."""
    if trajectory is None:
        builder.ExportInput(port, port.get_name())
        return
    source = TrajectorySource(trajectory)
    source = builder.AddNamedSystem(f"{port.get_name()}_source", source)
    builder.Connect(source.get_output_port(), port)


def _Join(
    builder: DiagramBuilder, name: str, ports: list[OutputPort]
) -> OutputPort:
    join = Multiplexer([port.size() for port in ports])
    join = builder.AddNamedSystem(name, join)
    for i, port in enumerate(ports):
        builder.Connect(port, join.get_input_port(i))
    return join.get_output_port()

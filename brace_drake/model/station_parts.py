"""What all diagrams of a brace are built of, the bench's as well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    Multiplexer,
    Saturation,
    TrajectorySource,
)
from pydrake.trajectories import Trajectory

from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn
from brace_drake.model.brace_plant import (
    AddBracePlant,
    AddGeometry,
    plant_resolves_contact,
)
from brace_drake.model.systems.brace_forces import (
    BraceForces,
    ConnectBraceForces,
)
from brace_drake.model.systems.contact_force import AddContactForce
from brace_drake.model.systems.instruments import BraceInstruments
from brace_drake.scenario.brace import BraceScenario


@dataclass
class BraceParts:
    """The brace without drives, instruments and controller.

    Attributes:
        plant: Of rings and torso, and legs where they are bodies.
        forces: On them.
        legs: Inputs for the legs' forces (6 S,), N, all to be fed alike.
    """

    plant: MultibodyPlant
    forces: BraceForces
    legs: list[InputPort]

    @property
    def measured(self) -> OutputPort:
        """What instruments see, exactly (9 S + 3,), see BraceForces."""
        return self.forces.GetOutputPort("measured")


def AddBrace(
    builder: DiagramBuilder,
    scenario: BraceScenario,
    numbers: BraceNumbers,
    plug_ins: Mapping[str, PlugIn],
    add_geometry: AddGeometry | None = None,
) -> BraceParts:
    """Adds bodies and the forces on them.

    Args:
        builder: Of the diagram.
        scenario: Of the brace.
        numbers: Of the brace; effects may have changed them.
        plug_ins: Of the effects, by plug point.
        add_geometry: See `AddBracePlant`.
    """
    plant = AddBracePlant(builder, scenario, add_geometry)
    forces, legs = _AddForces(builder, plant, scenario, numbers, plug_ins)
    if plant_resolves_contact(scenario):
        AddContactForce(builder, plant, scenario.rings, forces)
    return BraceParts(plant, forces, legs)


def AddDrives(
    builder: DiagramBuilder, scenario: BraceScenario, parts: BraceParts
) -> Saturation:
    """Adds drives that give what they can of the commands (6 S,), N."""
    limit = np.full(6 * len(scenario.stages), scenario.leg.force_limit)
    drives = builder.AddNamedSystem("drives", Saturation(-limit, limit))
    for port in parts.legs:
        builder.Connect(drives.get_output_port(), port)
    return drives


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
            numbers,
            plant.time_step(),
            scenario.torso.present,
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
    return Join(builder, "bodies_state", [*q, *v])


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
        Join(builder, "applied_force", blocks),
        plant.get_applied_generalized_force_input_port(),
    )
    return split.get_input_port()


def AddInstruments(
    builder: DiagramBuilder,
    parts: BraceParts,
    drives: Saturation,
    numbers: BraceNumbers,
    period: float,
    noise: Trajectory | None,
    plug_ins: Mapping[str, PlugIn],
) -> tuple[dict[str, OutputPort], OutputPort]:
    """Adds instruments; without noise they read what is there, exactly.

    Returns:
        Readings by name: `leg_length`, `force`, `marker`; and all of them as a
        log takes them.
    """
    n = numbers.num_stages
    instruments = builder.AddNamedSystem(
        "instruments",
        BraceInstruments(
            numbers.resolution, numbers.noise_sigma, period, plug_ins
        ),
    )
    for source, port in (
        (parts.measured, "measured"),
        (drives.get_output_port(), "held_command"),
    ):
        builder.Connect(source, instruments.GetInputPort(port))
    Feed(builder, instruments.GetInputPort("noise"), noise)
    split = builder.AddNamedSystem("readings", Demultiplexer([6 * n, 3 * n, 3]))
    builder.Connect(instruments.get_output_port(0), split.get_input_port())
    names = ("leg_length", "force", "marker")
    readings = {name: split.get_output_port(i) for i, name in enumerate(names)}
    return readings, instruments.logged_port


def Feed(
    builder: DiagramBuilder,
    port: InputPort,
    values: Trajectory | OutputPort | None,
) -> None:
    """Feeds a port from a trajectory or another port, or exports it."""
    if values is None:
        builder.ExportInput(port, port.get_name())
        return
    if isinstance(values, Trajectory):
        source = TrajectorySource(values)
        source = builder.AddNamedSystem(f"{port.get_name()}_source", source)
        values = source.get_output_port()
    builder.Connect(values, port)


def Join(
    builder: DiagramBuilder, name: str, ports: list[OutputPort]
) -> OutputPort:
    """Ports side by side, in the order given."""
    join = Multiplexer([port.size() for port in ports])
    join = builder.AddNamedSystem(name, join)
    for i, port in enumerate(ports):
        builder.Connect(port, join.get_input_port(i))
    return join.get_output_port()

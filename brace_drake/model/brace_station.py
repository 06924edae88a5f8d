"""A brace of one or more stages as a Drake diagram, ports named by role."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    OutputPort,
    System,
)
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink
from pydrake.trajectories import Trajectory

from brace_drake.core.errors import EffectError, ScenarioError
from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.brace_plant import AddGeometry, plant_resolves_contact
from brace_drake.model.station_parts import (
    AddBrace,
    AddDrives,
    AddInstruments,
    Feed,
    Join,
)
from brace_drake.model.station_safety import NAME, AddSupervisor, Supervision
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.model.systems.contact_force import AddPadForceLog
from brace_drake.model.systems.safety_supervisor import SafetySupervisor
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_rings
from brace_drake.scenario.controllers import BraceControl
from brace_drake.scenario.effects import scenario_uses


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

    `sink` logs drive forces (6 S), leg lengths (6 S), forces (3 S), marker (3)
    and, of a controller, X_v, X_v', X_v'' (18 S) every `log_period`, at a tick;
    `state_sink` the plant's state; `pad_sink`, where it was asked for and the
    plant resolves contact, the force of each pad on the torso (6 S), N, left
    before right.
    """

    diagram: Diagram
    plant: MultibodyPlant
    numbers: BraceNumbers
    sink: VectorLogSink
    state_sink: VectorLogSink
    pad_sink: VectorLogSink | None = None

    @property
    def supervisor(self) -> SafetySupervisor | None:
        """What may have stopped it, where it was built with limits."""
        if not self.diagram.HasSubsystemNamed(NAME):
            return None
        return self.diagram.GetSubsystemByName(NAME)


def MakeControlledBrace(
    scenario: BraceScenario, desired: Trajectory | None = None, **options
) -> BraceStation:
    """Builds the brace of a scenario around the controller that it names.

    Args:
        scenario, desired: See `MakeBraceStation`.
        options: Its other arguments.
    """
    return MakeBraceStation(scenario, scenario.control, desired, **options)


def MakeBraceStation(
    scenario: BraceScenario,
    controller: System | BraceControl | None = None,
    desired: Trajectory | None = None,
    noise: Trajectory | None = None,
    add_geometry: AddGeometry | None = None,
    uses: Sequence[Use] = (),
    log_pads: bool = False,
    limits: Limits | None = None,
) -> BraceStation:
    """Builds the brace of a scenario around a controller.

    Args:
        scenario: Checked; its effects are always on.
        controller: LeafSystem or Diagram with inputs `leg_length` (6 S,),
            `force` (3 S,), `desired` (18 S,), possibly `stiffness` (6 S,), and
            outputs `leg_command` (6 S,), `virtual` (18 S,), `impedance`
            (18 S,), held from its last tick; or the numbers of one.
        desired: X_d, X_d', X_d'' (18 S rows), in place of the exported port.
        noise: Standard normal draws (9 S + 3 rows), constant around each
            tick, in place of the exported port.
        add_geometry: See `AddBracePlant`.
        uses: Effects with their parameters, beside those of the scenario.
        log_pads: Also log the forces of single pads, see `BraceStation`.
        limits: Of a supervisor behind the controller, which then has the
            output `estimate`; None: there is none.

    Raises:
        EffectError: Effects that this brace does not take.
        ScenarioError: The controller's ports are of another number of stages,
            or a ring of the articulated brace is too light for its legs.
    """
    uses = (*scenario_uses(scenario), *uses)
    _check_contact(scenario, uses)
    numbers = modify_numbers(pack_brace(scenario), uses)
    if isinstance(controller, BraceControl):
        rings = pack_rings(scenario)
        controller = MakeController(controller, rings, numbers.control)
    else:
        _check_control(scenario, numbers, uses)
    mass, *inertia = numbers.ring[0, 0:4]
    ring = replace(scenario.ring, mass=mass, inertia=np.array(inertia))
    scenario = replace(scenario, ring=ring)
    plug_ins, builder = stack_effects(uses, numbers), DiagramBuilder()
    parts = AddBrace(builder, scenario, numbers, plug_ins, add_geometry)
    drives = AddDrives(builder, scenario, parts)
    period, drive_force = 1.0 / scenario.control.rate, drives.get_output_port()
    readings, read = AddInstruments(
        builder, parts, drives, numbers, period, noise, plug_ins
    )
    ports = {"drive_force": drive_force, **readings}
    if controller is None:
        builder.ExportInput(drives.get_input_port(), "leg_command")
    else:
        _check_ports(controller, numbers.num_stages)
        supervision = None
        if limits is not None:
            rings = pack_rings(scenario)
            supervision = Supervision(limits, rings, numbers.viscous, period)
        ports |= ConnectController(
            builder, controller, readings, drives, desired,
            supervision=supervision,
        )  # fmt: skip
    row = [drive_force, read, *(ports[n] for n in ("virtual",) if n in ports)]
    sinks = _AddLogs(builder, scenario, parts.plant, row, log_pads)
    state = parts.plant.get_state_output_port()
    for name, port in {"plant_state": state, **ports}.items():
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("brace_station")
    return BraceStation(diagram, parts.plant, numbers, *sinks)


def _check_contact(scenario: BraceScenario, uses: Sequence[Use]) -> None:
    """Refuses effects whose plug points the plant's own contact has not."""
    for effect, _ in uses if plant_resolves_contact(scenario) else ():
        if not {"compression", "contact"}.isdisjoint(effect.laws):
            raise EffectError(
                f"effect {effect.key} changes the linear contact; the scenario"
                " has contact.model hydroelastic"
            )


def _check_control(
    scenario: BraceScenario, numbers: BraceNumbers, uses: Sequence[Use]
) -> None:
    """Refuses effects on a controller that is a system of its own."""
    if not np.array_equal(pack_brace(scenario).control, numbers.control):
        names = ", ".join(e.key for e, _ in uses if e.modify is not None)
        raise EffectError(
            f"effect {names} changes the controller, which here is given as a"
            " system; allowed: effects of the brace"
        )


def _AddLogs(
    builder: DiagramBuilder,
    scenario: BraceScenario,
    plant: MultibodyPlant,
    row: list[OutputPort],
    log_pads: bool,
) -> tuple[VectorLogSink, VectorLogSink, VectorLogSink | None]:
    """Adds the logs of a station: `sink`, `state_sink`, `pad_sink`."""
    period, sinks = scenario.sensors.log_period, []
    logged = Join(builder, "log_row", row)
    state = plant.get_state_output_port()
    for name, port in (("log", logged), ("state_log", state)):
        sinks.append(LogVectorOutput(port, builder, period))
        sinks[-1].set_name(name)
    if not (log_pads and plant_resolves_contact(scenario)):
        return sinks[0], sinks[1], None
    return (*sinks, AddPadForceLog(builder, plant, scenario.rings, period))


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


def ConnectController(
    builder: DiagramBuilder,
    controller: System,
    readings: dict[str, OutputPort],
    drives: System,
    desired: Trajectory | OutputPort | None,
    stiffness: OutputPort | None = None,
    supervision: Supervision | None = None,
) -> dict[str, OutputPort]:
    """Adds a controller between readings and what takes its commands.

    With `supervision` there is a safety supervisor behind it.

    Inputs that nothing feeds are exported.

    Returns:
        Its outputs that are exported, by name.
    """
    # In a diagram, a system without a name is given its address as one.
    if not controller.get_name():
        controller.set_name("controller")
    builder.AddSystem(controller)
    for name in ("leg_length", "force"):
        builder.Connect(readings[name], controller.GetInputPort(name))
    Feed(builder, controller.GetInputPort("desired"), desired)
    if controller.HasInputPort("stiffness"):
        Feed(builder, controller.GetInputPort("stiffness"), stiffness)
    ports = {
        name: controller.GetOutputPort(name)
        for name in ("leg_command", "virtual", "impedance", "estimate")
        if controller.HasOutputPort(name)
    }
    if supervision is None:
        builder.Connect(ports["leg_command"], drives.get_input_port())
    else:
        AddSupervisor(builder, supervision, readings, ports, drives)
    return ports

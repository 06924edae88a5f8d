"""The bench as a Drake diagram with ports named by role."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    LogVectorOutput,
    Multiplexer,
    TrajectorySource,
    VectorLogSink,
)
from pydrake.trajectories import Trajectory

from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.errors import EffectError
from brace_drake.plant import (
    AddBenchPlant,
    AddStateLog,
    plant_resolves_contact,
)
from brace_drake.scenario.bench import BenchScenario, Ring
from brace_drake.scenario.bench_numbers import BenchNumbers, pack_bench
from brace_drake.scenario.effects import scenario_uses
from brace_drake.systems.brace_forces import (
    BraceForces,
    ConnectBraceForces,
    pack_bench_law,
)
from brace_drake.systems.contact_force_hold import AddContactForce
from brace_drake.systems.controller_blocks import (
    BraceInverseDynamics,
    ImpedanceFilter,
    PoseEstimator,
    TickHold,
)
from brace_drake.systems.instruments import BraceInstruments
from brace_drake.systems.pic_controller import PicController, pack_tick_law


@dataclass
class BenchStation:
    """A built bench: the diagram and the parts that callers reach for.

    Exported ports of the diagram: input `noise` (12,), standard normal draws
    that hold for a control tick (unconnected: exact readings); outputs
    `plant_state` and, of the last tick, `leg_command` (6,), N, `readings`
    (12,), and `virtual` (4,): filtered force, virtual position, velocity,
    acceleration. `sink` logs the last three side by side, in layout `pic` with
    the memory of the pose estimator behind them. `state_sink` logs the plant's
    state.
    """

    diagram: Diagram
    plant: MultibodyPlant
    sink: VectorLogSink
    state_sink: VectorLogSink


def MakeBenchStation(
    scenario: BenchScenario,
    reference: Trajectory,
    uses: Sequence[Use] = (),
    noise: Trajectory | None = None,
) -> BenchStation:
    """Builds the bench of a scenario that follows a reference.

    Args:
        scenario: Numbers of the nominal twin, and effects that are always on.
        reference: y_d, y_d', y_d'' as a trajectory of three rows.
        uses: Effects with their parameters, beside those of the scenario.
        noise: Standard normal draws (12 rows), constant around each tick, in
            place of the exported port.

    Raises:
        EffectError: More effects than the twin carries, or effects of a
            contact that the plant resolves.
    """
    uses = (*scenario_uses(scenario), *uses)
    _check_contact(scenario, uses)
    numbers = modify_numbers(pack_bench(scenario), uses)
    plug_ins = stack_effects(uses, numbers)
    builder = DiagramBuilder()
    # Bodies, and the forces on them.
    plant = AddBenchPlant(builder, _with_bodies(scenario, numbers))
    forces, leg_command = _AddForces(
        builder, plant, scenario, numbers, plug_ins
    )
    if plant_resolves_contact(scenario):
        AddContactForce(builder, plant, ["ring2"], forces)
    # Reference, then instruments and controller.
    source = builder.AddNamedSystem("reference", TrajectorySource(reference))
    add = _CONTROLLERS[scenario.control.layout]
    measured = forces.GetOutputPort("measured")
    desired = source.get_output_port()
    ports, logged = add(builder, measured, desired, numbers, plug_ins)
    builder.Connect(ports["leg_command"], leg_command)
    # Ports and logs.
    noise_port = ports.pop("noise")
    if noise is None:
        builder.ExportInput(noise_port, "noise")
    else:
        draws = builder.AddNamedSystem("draws", TrajectorySource(noise))
        builder.Connect(draws.get_output_port(), noise_port)
    builder.ExportOutput(plant.get_state_output_port(), "plant_state")
    for name, port in ports.items():
        builder.ExportOutput(port, name)
    sink = LogVectorOutput(logged, builder, scenario.sensors.log_period)
    sink.set_name("log")
    state_sink = AddStateLog(builder, plant, scenario.sensors.log_period)
    diagram = builder.Build()
    diagram.set_name("bench_station")
    return BenchStation(diagram, plant, sink, state_sink)


def _check_contact(scenario: BenchScenario, uses: Sequence[Use]) -> None:
    """Refuses effects whose plug points the plant's own contact has not."""
    if not plant_resolves_contact(scenario):
        return
    for effect, _ in uses:
        if not {"compression", "contact"}.isdisjoint(effect.laws):
            raise EffectError(
                f"effect {effect.key} changes the linear contact; the scenario"
                " has contact.model hydroelastic"
            )


def _with_bodies(
    scenario: BenchScenario, numbers: BenchNumbers
) -> BenchScenario:
    """The scenario with the ring as effects have changed it."""
    return replace(scenario, ring=Ring(numbers.ring[0], numbers.ring[1:4]))


def _AddForces(builder, plant, scenario, numbers, plug_ins):
    """Adds legs, posture and pads around the plant.

    Returns:
        The system, and the input port for the leg commands.
    """
    with_torso = scenario.torso.present
    forces = builder.AddNamedSystem(
        "forces",
        BraceForces(
            1,
            plant.time_step(),
            with_torso,
            with_pads=with_torso and not plant_resolves_contact(scenario),
            plug_ins=plug_ins,
        ),
    )
    leg_command = ConnectBraceForces(
        builder,
        forces,
        pack_bench_law(numbers),
        plant.get_state_output_port(),
        plant.get_applied_generalized_force_input_port(),
    )
    return forces, leg_command


def _AddPicController(builder, measured, desired, numbers, plug_ins):
    """Adds the controller as one system.

    Returns:
        Its ports by role, and the port to log.
    """
    add = builder.AddNamedSystem
    pic = add("pic_controller", PicController(numbers, plug_ins))
    law = add("pic_law", ConstantVectorSource(pack_tick_law(numbers)))
    split = add("tick_split", Demultiplexer(np.array([6, 12, 4, 20])))
    tick = pic.GetOutputPort("tick")
    for source, name in (
        (measured, "measured"),
        (desired, "desired"),
        (law.get_output_port(), "law"),
    ):
        builder.Connect(source, pic.GetInputPort(name))
    builder.Connect(tick, split.get_input_port())
    ports = {
        "noise": pic.GetInputPort("noise"),
        "leg_command": split.get_output_port(0),
        "readings": split.get_output_port(1),
        "virtual": split.get_output_port(2),
    }
    return ports, tick


def _AddControllerBlocks(builder, measured, desired, numbers, plug_ins):
    """Adds the controller block by block, as `_AddPicController`."""
    add = builder.AddNamedSystem
    instruments = add(
        "instruments",
        BraceInstruments(
            numbers.resolution,
            numbers.noise_sigma,
            numbers.estimator[3],
            plug_ins,
        ),
    )
    split = add("readings_split", Demultiplexer(np.array([6, 3, 3])))
    estimator = add("pose_estimator", PoseEstimator(numbers))
    impedance = add("impedance_filter", ImpedanceFilter(numbers))
    dynamics = add("inverse_dynamics", BraceInverseDynamics(numbers))
    hold = add("tick_hold", TickHold(numbers.estimator[3]))
    readings = instruments.GetOutputPort("readings")
    leg_command = hold.GetOutputPort("leg_command")
    for source, system, port in (
        (measured, instruments, "measured"),
        (leg_command, instruments, "held_command"),
        (readings, hold, "readings"),
        (split.get_output_port(0), estimator, "leg_length"),
        (split.get_output_port(1), impedance, "force"),
        (desired, impedance, "desired"),
        (estimator.get_output_port(), dynamics, "estimated_state"),
        (impedance.GetOutputPort("virtual"), dynamics, "virtual"),
        (dynamics.get_output_port(), hold, "command"),
    ):
        builder.Connect(source, system.GetInputPort(port))
    builder.Connect(readings, split.get_input_port())
    held = {
        "leg_command": leg_command,
        "readings": hold.GetOutputPort("readings"),
        "virtual": impedance.GetOutputPort("held_virtual"),
    }
    row = add("log_row", Multiplexer([port.size() for port in held.values()]))
    for i, port in enumerate(held.values()):
        builder.Connect(port, row.get_input_port(i))
    ports = {"noise": instruments.GetInputPort("noise"), **held}
    return ports, row.get_output_port()


_CONTROLLERS = {"pic": _AddPicController, "blocks": _AddControllerBlocks}

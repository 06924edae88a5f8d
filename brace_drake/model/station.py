"""The bench as a Drake diagram: the brace with stage 2 alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import MatrixGain, TrajectorySource
from pydrake.trajectories import Trajectory

from brace_drake.core.errors import EffectError
from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.brace_plant import plant_resolves_contact
from brace_drake.model.brace_station import (
    BraceStation,
    ConnectController,
    FinishStation,
    pads_of,
)
from brace_drake.model.station_parts import (
    AddBrace,
    AddDrives,
    AddInstruments,
    BraceParts,
    Join,
)
from brace_drake.model.station_safety import Supervision
from brace_drake.model.systems.brace_controllers import BracePic
from brace_drake.scenario.bench_numbers import (
    pack_bench,
    pack_bench_control,
    pack_plant,
)
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings
from brace_drake.scenario.control_numbers import ControlNumbers
from brace_drake.scenario.effects import scenario_uses


@dataclass
class _Loop:
    """What drives, instruments and controller are made of."""

    scenario: BraceScenario
    numbers: BraceNumbers
    control: ControlNumbers
    plug_ins: Mapping[str, PlugIn]
    noise: Trajectory | None
    limits: Limits | None


def MakeBenchStation(
    scenario: BenchScenario,
    reference: Trajectory,
    uses: Sequence[Use] = (),
    noise: Trajectory | None = None,
    log_pads: bool = False,
    limits: Limits | None = None,
) -> BraceStation:
    """Builds the bench of a scenario that follows a reference.

    It is the brace of one stage, with PIC along y;
    `sink` logs X_v, X_v', X_v'' (18,) behind the rest.

    Args:
        scenario: Numbers of the nominal twin, and effects that are always on.
        reference: y_d, y_d', y_d'' as a trajectory of three rows.
        uses: Effects with their parameters, beside those of the scenario.
        noise: Standard normal draws (12 rows), constant around each tick, in
            place of the exported port.
        log_pads: Also log the forces of single pads, see `BraceStation`.
        limits: Of a supervisor behind the controller; None: there is none.

    Raises:
        EffectError: More effects than the twin carries, or effects of a
            contact that the plant resolves.
    """
    uses, brace = (*scenario_uses(scenario), *uses), replace(scenario)
    _check_contact(brace, uses)
    bench = modify_numbers(pack_bench(scenario), uses)
    plug_ins = stack_effects(uses, bench)
    mass, inertia = bench.ring[0, 0], bench.ring[0, 1:4]
    brace.ring = replace(brace.ring, mass=mass, inertia=inertia)
    numbers = pack_plant(brace, bench)
    builder = DiagramBuilder()
    parts = AddBrace(builder, brace, numbers, plug_ins)
    source = builder.AddNamedSystem("reference", TrajectorySource(reference))
    control = pack_bench_control(brace, bench)
    loop = _Loop(brace, numbers, control, plug_ins, noise, limits)
    ports, logged = _AddBlocks(builder, parts, source.get_output_port(), loop)
    period = scenario.sensors.log_period
    sinks = FinishStation(
        builder, parts.plant, ports, logged, period, pads_of(brace, log_pads)
    )
    diagram = builder.Build()
    diagram.set_name("bench_station")
    return BraceStation(diagram, parts.plant, numbers, *sinks)


def _check_contact(scenario: BraceScenario, uses: Sequence[Use]) -> None:
    """Refuses effects whose plug points the plant's own contact has not."""
    if not plant_resolves_contact(scenario):
        return
    for effect, _ in uses:
        if not {"compression", "contact"}.isdisjoint(effect.laws):
            raise EffectError(
                f"effect {effect.key} changes the linear contact; the scenario"
                " has contact.model hydroelastic"
            )


def _AddBlocks(
    builder: DiagramBuilder, parts: BraceParts, y: OutputPort, loop: _Loop
) -> tuple[dict[str, OutputPort], OutputPort]:
    """Adds drives, instruments and controller as the brace has them.

    Args:
        builder: Of the diagram.
        parts: Of the brace.
        y: y_d, y_d', y_d''.
        loop: Their numbers.

    Returns:
        Ports to export by name, and what to log.
    """
    rows = np.zeros((18, 3))
    rows[1::6] = np.eye(3)
    desired = builder.AddNamedSystem("along_y", MatrixGain(rows))
    builder.Connect(y, desired.get_input_port())
    drives = AddDrives(builder, loop.scenario, parts)
    readings, read = AddInstruments(
        builder,
        parts,
        drives,
        loop.numbers,
        loop.control.period,
        loop.noise,
        loop.plug_ins,
    )
    pic = BracePic(loop.control)
    pic.set_name("pic_controller")
    supervision = None
    if loop.limits is not None:
        rings = pack_rings(loop.scenario)
        supervision = Supervision(
            loop.limits, rings, loop.numbers.viscous, loop.control.period
        )
    ports = ConnectController(
        builder, pic, readings, drives, desired.get_output_port(),
        supervision=supervision,
    )  # fmt: skip
    ports = {"drive_force": drives.get_output_port(), **readings, **ports}
    row = [ports["drive_force"], read, ports["virtual"]]
    return ports, Join(builder, "log_row", row)

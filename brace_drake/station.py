"""The bench as a Drake diagram: the brace with stage 2 alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    MatrixGain,
    TrajectorySource,
)
from pydrake.trajectories import Trajectory

from brace_drake.brace_plant import plant_resolves_contact
from brace_drake.brace_station import (
    BraceStation,
    ConnectController,
    FinishStation,
)
from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.errors import EffectError
from brace_drake.laws import kernels
from brace_drake.laws.plug_in import PlugIn
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_brace import brace_of_bench
from brace_drake.scenario.bench_numbers import (
    pack_bench,
    pack_bench_brace,
    pack_bench_control,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import BraceNumbers
from brace_drake.scenario.control_numbers import ControlNumbers
from brace_drake.scenario.effects import scenario_uses
from brace_drake.station_parts import (
    AddBrace,
    AddInstruments,
    BraceParts,
    Feed,
)
from brace_drake.systems.brace_controllers import BracePic
from brace_drake.systems.pic_controller import PicController, pack_tick_law


@dataclass
class _Loop:
    """What instruments and controller are made of."""

    numbers: BraceNumbers
    control: ControlNumbers
    plug_ins: Mapping[str, PlugIn]
    desired: OutputPort
    noise: Trajectory | None


def MakeBenchStation(
    scenario: BenchScenario,
    reference: Trajectory,
    uses: Sequence[Use] = (),
    noise: Trajectory | None = None,
) -> BraceStation:
    """Builds the bench of a scenario that follows a reference.

    It is the brace of one stage, see `scenario.bench_brace`, with PIC along y;
    `sink` logs X_v, X_v', X_v'' (18,) behind the rest. In layout `blocks`
    instruments and controller are those of the brace; in `pic`, the faster
    one, they are one system, see PicController.

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
    uses, brace = (*scenario_uses(scenario), *uses), brace_of_bench(scenario)
    _check_contact(brace, uses)
    bench = modify_numbers(pack_bench(scenario), uses)
    plug_ins = stack_effects(uses, bench)
    mass, inertia = bench.ring[0], bench.ring[1:4]
    brace.ring = replace(brace.ring, mass=mass, inertia=inertia)
    numbers = pack_bench_brace(brace, bench)
    builder = DiagramBuilder()
    parts = AddBrace(builder, brace, numbers, plug_ins)
    control = pack_bench_control(brace, bench)
    desired = _AddReference(builder, reference)
    loop = _Loop(numbers, control, plug_ins, desired, noise)
    ports, logged = _LAYOUTS[scenario.control.layout](builder, parts, loop)
    logged = [*logged, ports["virtual"]]
    return FinishStation(
        builder, "bench_station", brace, numbers, parts, ports, logged
    )


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


def _AddReference(builder: DiagramBuilder, reference: Trajectory) -> OutputPort:
    """X_d, X_d', X_d'' (18,) of a reference along y."""
    add = builder.AddNamedSystem
    source = add("reference", TrajectorySource(reference))
    rows = np.zeros((18, 3))
    rows[1::6] = np.eye(3)
    along_y = add("along_y", MatrixGain(rows))
    builder.Connect(source.get_output_port(), along_y.get_input_port())
    return along_y.get_output_port()


def _AddBlocks(
    builder: DiagramBuilder, parts: BraceParts, loop: _Loop
) -> tuple[dict[str, OutputPort], list[OutputPort]]:
    """Adds instruments and controller as the brace has them.

    Returns:
        Ports to export by name, and readings to log.
    """
    readings, logged = AddInstruments(
        builder,
        parts,
        loop.numbers,
        loop.control.period,
        loop.noise,
        loop.plug_ins,
    )
    pic = BracePic(loop.control)
    pic.set_name("pic_controller")
    ports = ConnectController(builder, pic, readings, parts, loop.desired)
    return readings | ports, [logged]


def _AddPic(
    builder: DiagramBuilder, parts: BraceParts, loop: _Loop
) -> tuple[dict[str, OutputPort], list[OutputPort]]:
    """Adds both as one system; arguments and results as `_AddBlocks`."""
    add, n = builder.AddNamedSystem, loop.numbers.num_stages
    pic = add("pic_controller", PicController(loop.control, loop.plug_ins))
    law = pack_tick_law(loop.numbers, loop.control)
    law = add("pic_law", ConstantVectorSource(law))
    split = add("tick_split", Demultiplexer(list(kernels.tick_sizes(n))))
    for source, name in (
        (parts.measured, "measured"),
        (loop.desired, "desired"),
        (law.get_output_port(), "law"),
    ):
        builder.Connect(source, pic.GetInputPort(name))
    Feed(builder, pic.GetInputPort("noise"), loop.noise)
    builder.Connect(pic.GetOutputPort("tick"), split.get_input_port())
    names = (
        "leg_command", "leg_length", "force", "marker", "virtual", "impedance",
    )  # fmt: skip
    ports = {name: split.get_output_port(i) for i, name in enumerate(names)}
    builder.Connect(ports["leg_command"], parts.drives.get_input_port())
    return ports, [ports[name] for name in names[1:4]]


_LAYOUTS = {"pic": _AddPic, "blocks": _AddBlocks}

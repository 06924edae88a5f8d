"""The pad bench as a Drake diagram with ports named by role."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
)
from pydrake.systems.primitives import (
    LogVectorOutput,
    TrajectorySource,
    VectorLogSink,
)
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.devices.pad_bench.twin import steps_per_sample
from brace_drake.laws.loop.pad_rollout import (
    FORCE_AXIS,
    NUM_LEGS,
    calc_normal_force,
    calc_pad_compression,
    cut_normal_force,
)
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.model.systems.hosting import EffectHost
from brace_drake.model.systems.ticks import DeclareTick
from brace_drake.scenario.pad_bench import PadBenchNumbers


class PadContact(LeafSystem):
    """Force of a pad on tissue: N = max(0, k d + c d') with effects.

    Input ports:
        pad_state: Displacement, m, and rate, m/s (2,).

    Output ports:
        normal_force: (1,), N, not negative.

    Numeric parameters: contact (6,), as `calc_pad_compression` takes it;
    those of the effects at `compression` and `contact`, whose states advance
    once in each step.
    """

    def __init__(
        self,
        contact: np.ndarray,
        plug_ins: Mapping[str, PlugIn],
        time_step: float,
    ):
        super().__init__()
        self._dt = time_step
        self._state_port = self.DeclareVectorInputPort("pad_state", 2)
        self._law = int(self.DeclareNumericParameter(BasicVector(contact)))
        self._compression, self._contact = (
            EffectHost(self, plug_ins.get(point) or idle(point))
            for point in ("compression", "contact")
        )
        self.DeclareVectorOutputPort("normal_force", 1, self._CalcForce)
        if not (self._compression.is_idle and self._contact.is_idle):
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )

    def _EvalContact(self, context: Context):
        """The normal force and the effects' advanced states."""
        path = np.array(self._state_port.Eval(context))
        law = context.get_numeric_parameter(self._law).CopyToVector()
        d, N = np.empty(2), np.empty(1)
        hosts = self._compression, self._contact
        memories = [host.memory(context) for host in hosts]
        now = context.get_time(), self._dt, 0
        calc_pad_compression(path, law, d)
        hosts[0].apply(context, memories[0], *now, d)
        calc_normal_force(d, law, N)
        hosts[1].apply(context, memories[1], *now, d, law, N)
        cut_normal_force(d, N)
        return N, memories

    def _CalcForce(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._EvalContact(context)[0])

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        _, memories = self._EvalContact(context)
        self._compression.store(memories[0], discrete)
        self._contact.store(memories[1], discrete)


class LoadCell(LeafSystem):
    """Force readings at ticks, with the effects at `sensing`.

    Input ports:
        normal_force: (1,), N.

    Output ports, of the last tick and held until the next:
        reading: (1,), N.

    Numeric parameters: those of the effects, whose states advance at ticks.
    """

    def __init__(self, sensing: PlugIn, period: float):
        super().__init__()
        self._period = period
        self._force_port = self.DeclareVectorInputPort("normal_force", 1)
        self._host = EffectHost(self, sensing)
        self._reading = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("reading", self._reading)
        DeclareTick(self, period, self._Tick)

    def _Tick(self, context: Context, discrete) -> None:
        F, memory = np.zeros(3), self._host.memory(context)
        F[FORCE_AXIS] = self._force_port.Eval(context)[0]
        u, lengths = np.zeros(NUM_LEGS), np.zeros(NUM_LEGS)
        now = context.get_time(), self._period
        self._host.apply(context, memory, *now, u, lengths, F)
        if not self._host.is_idle:
            self._host.store(memory, discrete)
        discrete.get_mutable_vector(self._reading).SetFromVector(
            F[FORCE_AXIS : FORCE_AXIS + 1]
        )


@dataclass
class PadBenchStation:
    """A built pad bench: the diagram and the parts that callers reach for.

    Exported outputs of the diagram: `pad_state` (2,), `normal_force` (1,), N,
    and, of the last tick, `reading` (1,), N.
    """

    diagram: Diagram
    sink: VectorLogSink
    duration: float  # s, to the last sample


def MakePadBenchStation(
    numbers: PadBenchNumbers,
    time: np.ndarray,
    path: np.ndarray,
    time_step: float,
    plug_ins: Mapping[str, PlugIn] | None = None,
) -> PadBenchStation:
    """Builds the pad bench that is to follow a path.

    Args:
        numbers: Of the contact.
        time: Evenly spaced sample times from 0 (N,), s.
        path: Displacement, m, and rate, m/s, at the samples (N, 2).
        time_step: Longest step of the effects' states, s.
        plug_ins: Effects by plug point.
    """
    builder, plug_ins = DiagramBuilder(), plug_ins or {}
    period = time[-1] / (len(time) - 1)
    source = builder.AddNamedSystem(
        "path", TrajectorySource(MakePath(time, path), 1)
    )
    contact = builder.AddNamedSystem(
        "contact",
        PadContact(
            numbers.contact,
            plug_ins,
            period / steps_per_sample(time, time_step),
        ),
    )
    cell = builder.AddNamedSystem(
        "load_cell",
        LoadCell(plug_ins.get("sensing") or idle("sensing"), period),
    )
    state, force = source.get_output_port(), contact.GetOutputPort
    builder.Connect(state, contact.GetInputPort("pad_state"))
    builder.Connect(force("normal_force"), cell.GetInputPort("normal_force"))
    reading = cell.GetOutputPort("reading")
    builder.ExportOutput(state, "pad_state")
    builder.ExportOutput(force("normal_force"), "normal_force")
    builder.ExportOutput(reading, "reading")
    sink = LogVectorOutput(reading, builder, period)
    sink.set_name("log")
    diagram = builder.Build()
    diagram.set_name("pad_bench_station")
    return PadBenchStation(diagram, sink, float(time[-1]))


def MakePath(time: np.ndarray, path: np.ndarray) -> PiecewisePolynomial:
    """The cubic Hermite through displacements and rates (N, 2)."""
    return PiecewisePolynomial.CubicHermite(time, path[:, :1].T, path[:, 1:].T)


def SimulatePadBench(station: PadBenchStation) -> np.ndarray:
    """Simulates the path; returns the readings (N,), N."""
    simulator = Simulator(station.diagram)
    # A little further, so that the last sample is among the events.
    simulator.AdvanceTo(station.duration + 1e-6)
    return station.sink.FindLog(simulator.get_context()).data()[0]

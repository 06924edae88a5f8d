"""The leg bench as a Drake diagram with ports named by role."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
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

from brace_drake.core.resources import sdf_path
from brace_drake.devices.leg_bench.twin import LegMotion
from brace_drake.laws.loop.leg_rollout import (
    calc_drive_force,
    calc_servo_command,
)
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.model.systems.hosting import EffectHost
from brace_drake.model.systems.ticks import DeclareTick
from brace_drake.scenario.leg_bench import LegBenchNumbers


class DriveServo(LeafSystem):
    """Position control at ticks: u = kv (kp (y_d - y) - v) + f_a, limited.

    v is the difference of the mean of two successive readings.

    Input ports:
        plant_state: y, y' (2,); the position is what the servo reads.
        asked: y_d, m, force added to the command, N, further load on the
            drive, N (3,).

    Output ports, all of the last tick and held until the next:
        command: u (1,), N.
        load: (1,), N.
        reading: y (1,), m.

    Numeric parameters: control (4,) kp, kv, limit, period.
    """

    def __init__(self, control: np.ndarray, previous: np.ndarray):
        super().__init__()
        self._state_port = self.DeclareVectorInputPort("plant_state", 2)
        self._asked_port = self.DeclareVectorInputPort("asked", 3)
        self._control = int(self.DeclareNumericParameter(BasicVector(control)))
        self._previous = self.DeclareDiscreteState(previous)
        self._command, self._load, self._reading = (
            self.DeclareDiscreteState(1) for _ in range(3)
        )
        self.DeclareStateOutputPort("command", self._command)
        self.DeclareStateOutputPort("load", self._load)
        self.DeclareStateOutputPort("reading", self._reading)
        DeclareTick(self, control[3], self._Tick)

    def _Tick(self, context: Context, discrete) -> None:
        reading = self._state_port.Eval(context)[0]
        asked = self._asked_port.Eval(context)
        control = context.get_numeric_parameter(self._control).CopyToVector()
        previous = context.get_discrete_state(self._previous).CopyToVector()
        u = np.empty(1)
        calc_servo_command(reading, asked, control, previous, u)
        for state, value in (
            (self._previous, previous),
            (self._command, u),
            (self._load, asked[2:]),
            (self._reading, [reading]),
        ):
            discrete.get_mutable_vector(state).SetFromVector(value)


class DriveForce(LeafSystem):
    """Force on the carriage: u - b y' with effects, minus offset, plus load.

    Input ports:
        plant_state: y, y' (2,).
        command: u (1,), N.
        load: (1,), N.

    Output ports:
        generalized_force: (1,), N.

    Numeric parameters: viscous (1,), N s/m; offset (1,), N; those of the
    effects at `drive`, whose states advance once in each plant step.
    """

    def __init__(
        self, numbers: LegBenchNumbers, drive: PlugIn, time_step: float
    ):
        super().__init__()
        self._dt = time_step
        self._state_port, self._command_port, self._load_port = (
            self.DeclareVectorInputPort(name, size)
            for name, size in (("plant_state", 2), ("command", 1), ("load", 1))
        )
        self._viscous, self._offset = (
            int(self.DeclareNumericParameter(BasicVector(a)))
            for a in (numbers.viscous, numbers.offset)
        )
        self._host = EffectHost(self, drive)
        self.DeclareVectorOutputPort("generalized_force", 1, self._CalcForce)
        if not self._host.is_idle:
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )

    def _EvalDrive(self, context: Context):
        """The drive's force and the effects' advanced states."""
        u = self._command_port.Eval(context)
        state, f = np.array(self._state_port.Eval(context)), np.empty(1)
        position, velocity = state[0:1], state[1:2]
        viscous = context.get_numeric_parameter(self._viscous).CopyToVector()
        calc_drive_force(u, viscous, velocity, f)
        memory = self._host.memory(context)
        if not self._host.is_idle:
            now = context.get_time(), self._dt
            leg = u, position, velocity, viscous, f
            self._host.apply(context, memory, *now, *leg)
        return f, memory

    def _CalcForce(self, context: Context, output: BasicVector) -> None:
        f, _ = self._EvalDrive(context)
        offset = context.get_numeric_parameter(self._offset).value()
        output.SetFromVector(f - offset + self._load_port.Eval(context))

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        _, memory = self._EvalDrive(context)
        self._host.store(memory, discrete)


@dataclass
class LegBenchStation:
    """A built leg bench: the diagram and the parts that callers reach for.

    Exported outputs of the diagram: `plant_state` (2,) and, of the last tick,
    `command` (1,), N, and `reading` (1,), m.
    """

    diagram: Diagram
    plant: MultibodyPlant
    sinks: dict[str, VectorLogSink]
    motion: LegMotion
    period: float  # s, of a tick


def MakeLegBenchStation(
    numbers: LegBenchNumbers,
    motion: LegMotion,
    time_step: float,
    drive: PlugIn | None = None,
) -> LegBenchStation:
    """Builds the leg bench that is to carry out a motion.

    Args:
        numbers: Of the drive and its control.
        motion: Reference, loads, and state at the start.
        time_step: Plant step, s.
        drive: Effects in the drive.
    """
    builder = DiagramBuilder()
    control, period = numbers.control, numbers.control[3]
    if not motion.closed:
        control = np.array([0.0, 0.0, math.inf, period])
    plant = AddLegDrivePlant(builder, numbers.mass[0], time_step)
    force = builder.AddNamedSystem(
        "drive_force", DriveForce(numbers, drive or idle("drive"), time_step)
    )
    source = builder.AddNamedSystem(
        "asked", TrajectorySource(MakeAsked(motion.asked, period))
    )
    servo = builder.AddNamedSystem(
        "servo", DriveServo(control, motion.previous)
    )
    state = plant.get_state_output_port()
    for output, system, port in (
        (state, force, "plant_state"),
        (servo.GetOutputPort("command"), force, "command"),
        (servo.GetOutputPort("load"), force, "load"),
        (state, servo, "plant_state"),
        (source.get_output_port(), servo, "asked"),
    ):
        builder.Connect(output, system.GetInputPort(port))
    builder.Connect(
        force.GetOutputPort("generalized_force"),
        plant.get_applied_generalized_force_input_port(),
    )
    builder.ExportOutput(state, "plant_state")
    sinks = {}
    for name in ("command", "reading"):
        port = servo.GetOutputPort(name)
        builder.ExportOutput(port, name)
        sinks[name] = LogVectorOutput(
            port, builder, motion.ticks_per_sample * period
        )
        sinks[name].set_name(f"{name}_log")
    diagram = builder.Build()
    diagram.set_name("leg_bench_station")
    return LegBenchStation(diagram, plant, sinks, motion, period)


def AddLegDrivePlant(
    builder: DiagramBuilder, mass: float, time_step: float
) -> MultibodyPlant:
    """Adds the finalized plant of a carriage on its slide; mass in kg."""
    plant = builder.AddNamedSystem("plant", MultibodyPlant(time_step))
    root = ElementTree.parse(sdf_path("leg_drive.sdf")).getroot()
    root.find(".//inertial/mass").text = repr(float(mass))
    text = ElementTree.tostring(root, encoding="unicode")
    Parser(plant).AddModelsFromString(text, "sdf")
    # The servo's ticks must come before the plant's step.
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    return plant


def MakeAsked(asked: np.ndarray, period: float) -> PiecewisePolynomial:
    """What is asked at each tick (ticks, 3), held from half a period before.

    So the value at a tick does not hang on the rounding of its time.
    """
    breaks = (np.arange(len(asked) + 1) - 0.5) * period
    held = np.vstack([asked, asked[-1:]])
    return PiecewisePolynomial.ZeroOrderHold(breaks, held.T)


def SimulateLegBench(station: LegBenchStation) -> np.ndarray:
    """Simulates the motion from its initial state.

    Returns:
        Log (samples, 2): command, N; reading, m.
    """
    simulator = Simulator(station.diagram)
    context = simulator.get_mutable_context()
    plant_context = station.plant.GetMyMutableContextFromRoot(context)
    station.plant.SetPositionsAndVelocities(plant_context, station.motion.state)
    # A little further, so that the last sample is among the events.
    last = (len(station.motion.asked) - 1) * station.period
    simulator.AdvanceTo(last + 1e-6)
    logs = [s.FindLog(context).data().T for s in station.sinks.values()]
    return np.hstack(logs)

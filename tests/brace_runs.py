"""Runs of the brace for tests of its mechanics."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.devices.motions.reference import MakeReference
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.simulate import SimulateStation
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace
from tests.brace_servo import BraceServo


def brace(mechanism="task_space", contact="none", **changes):
    """A scenario whose rings have all the same contact; "none": no torso."""
    scenario = BraceScenario(mechanism=mechanism, **changes)
    for pads in scenario.contact:
        pads.model = contact
    scenario.torso.present = contact != "none"
    return scenario


def way_to(X, duration, back=False):
    """X_d, X_d', X_d'' (18 S rows) from rest to X (6 S,), maybe back."""
    stops = [np.zeros(3 * len(X)), np.append(X, np.zeros(2 * len(X)))]
    stops += [stops[0]] if back else []
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(
        np.linspace(0.0, duration, len(stops)),
        np.column_stack(stops),
        np.zeros(3 * len(X)),
        np.zeros(3 * len(X)),
    )


def along_y(time, samples):
    """X_d, X_d', X_d'' (18 rows) of one ring from y, y', y'' (N, 3)."""
    desired = np.zeros((len(time), 3, 6))
    desired[:, :, 1] = samples
    return MakeReference(time, desired)


def bench_log(station, duration):
    """A run of a bench as its channels are recorded (N, 19)."""
    log, _ = SimulateStation(station, duration)
    return np.hstack([log[:, 0:18], log[:, 19:20]])


def hold(X):
    """X_d that stays at X (6 S,)."""
    return PiecewisePolynomial(np.append(X, np.zeros(2 * len(X)))[:, None])


def run(diagram, duration, watch=None):
    """The simulator after a run; `watch` sees the context at each step."""
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    # A callback finds its context's Python object faster than it makes one.
    kept = [s.GetMyContextFromRoot(context) for s in diagram.GetSystems()]
    if watch is not None:
        simulator.set_monitor(watch)
    simulator.AdvanceTo(duration + 1e-6)
    del kept
    return simulator


def run_servo(scenario, X, duration, watch=None, **options):
    """A station whose servo goes to X, and the log of its run."""
    servo = BraceServo(pack_brace(scenario))
    station = MakeBraceStation(scenario, servo, way_to(X, duration, **options))
    simulator = run(station.diagram, duration, watch and watch(station))
    context = simulator.get_context()
    return station, simulator, station.sink.FindLog(context).data().T


def replay(scenario, commands, duration, rate=1000.0):
    """A station driven by commands at ticks (ticks, 6 S), and its log."""
    station = MakeBraceStation(scenario)
    # A command acts from its own tick on.
    edges = np.arange(len(commands) + 1) / rate - 5e-10
    held = np.vstack([commands, commands[-1:]]).T
    held = PiecewisePolynomial.ZeroOrderHold(edges, held)
    builder = DiagramBuilder()
    inner = builder.AddSystem(station.diagram)
    source = builder.AddSystem(TrajectorySource(held))
    builder.Connect(source.get_output_port(), inner.GetInputPort("leg_command"))
    simulator = run(builder.Build(), duration)
    context = simulator.get_context()
    return station, simulator, station.sink.FindLog(context).data().T

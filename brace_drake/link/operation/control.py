"""The host's control of a device: its station's diagram, tick by tick."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from brace_drake.kinematics import holding_leg_forces
from brace_drake.laws.control import brace_control
from brace_drake.laws.control.pose_estimate import estimate_rings
from brace_drake.laws.cubic import calc_cubic
from brace_drake.laws.loop.force_left import calc_forces_left
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.brace_station import ConnectController
from brace_drake.model.systems.brace_controller import BraceController
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.model.systems.device_station import DeviceStation
from brace_drake.model.systems.stiffness_limiter import StiffnessLimiter
from brace_drake.model.systems.ticks import TICK_LEAD
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import (
    geometry_of,
    pack_brace,
    pack_rings,
)
from brace_drake.scenario.control_numbers import pack_control

# Of X of a ring (6,): y.
_ALONG = 1
# Places in a velocity [v; w] of task coordinates.
_ROTATION_FIRST = [3, 4, 5, 0, 1, 2]


def MakeHostStation(
    controller: BraceController,
    num_rings: int,
    period: float,
    stiffness: LeafSystem | None = None,
    limits: Limits | None = None,
) -> tuple[Diagram, DeviceStation]:
    """Builds a controller's station with a device in the plant's place.

    The controller is connected as in the stations of simulation. Exported
    ports of the diagram: input `desired` (18 S,); outputs `leg_command`,
    `virtual`, `impedance`, `estimate` of the controller.

    Args:
        controller: With an input `stiffness` where something sets it.
        num_rings: S, of the device.
        period: Of a tick, s.
        stiffness: With the ports of `learning.deployment.PolicySystem`:
            estimate and desired in, stiffness out; or None.
        limits: Of the stiffness and its rate, held behind `stiffness`.

    Returns:
        The diagram, and the device in it.
    """
    builder = DiagramBuilder()
    device = builder.AddNamedSystem("device", DeviceStation(num_rings))
    readings = {n: device.GetOutputPort(n) for n in ("leg_length", "force")}
    fed = None
    if stiffness is not None:
        builder.AddNamedSystem("stiffness", stiffness)
        limiter = StiffnessLimiter(limits, 6 * num_rings, period)
        builder.AddNamedSystem("limiter", limiter)
        builder.Connect(
            stiffness.GetOutputPort("stiffness"), limiter.get_input_port()
        )
        fed = limiter.get_output_port()
    ports = ConnectController(
        builder, controller, readings, device, None, stiffness=fed
    )
    if stiffness is not None:
        builder.Connect(ports["estimate"], stiffness.GetInputPort("estimate"))
        builder.ConnectInput("desired", stiffness.GetInputPort("desired"))
    for name, port in ports.items():
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("host_station")
    return diagram, device


class HostControl:
    """A scenario's controller on a device of S moving rings.

    There are n = 6 S coordinates and legs.

    Attributes:
        command: Leg commands of the last tick (n,), N.
        expected: What the legs left for the torso in it, by ring (3 S,), N.
        good: Whether ring poses fitted the lengths.
        hold: Leg forces that carry the rings' weight at rest (n,), N.
        period: Of a tick, s.
    """

    def __init__(
        self,
        scenario: BraceScenario,
        limits: Limits | None = None,
        stiffness: LeafSystem | None = None,
    ):
        """With the controller of the scenario.

        Args:
            scenario: Checked.
            limits: Of the stiffness and its rate, where something sets it.
            stiffness: What sets it, see `MakeHostStation`.

        Raises:
            ScenarioError: Numbers that are not allowed.
        """
        numbers, rings = pack_brace(scenario), pack_rings(scenario)
        self._controller = MakeController(scenario.control, rings)
        control = pack_control(scenario.control, rings)
        self._geometry, self._viscous = geometry_of(numbers), numbers.viscous
        self._rings = numbers.num_stages
        self._weights = np.ascontiguousarray(numbers.ring[:, 4])
        self._start_pose = control.pose
        self._rows = brace_control.take_geometry(control.law, self._rings)
        self._start = control.virtual[0 : 6 * self._rings]
        held = holding_leg_forces(self._geometry, self._weights)
        self.hold = tuple(held.tolist())
        self.period = control.period
        self.expected = np.zeros(3 * self._rings)
        diagram, self._device = MakeHostStation(
            self._controller, self._rings, self.period, stiffness, limits
        )
        self._simulator = Simulator(diagram)
        self._context = self._simulator.get_mutable_context()
        # A callback finds its context's Python object faster than it makes one.
        self._contexts = [
            system.GetMyContextFromRoot(self._context)
            for system in diagram.GetSystems()
        ]
        self._own = self._device.GetMyMutableContextFromRoot(self._context)
        self._desired = diagram.GetInputPort("desired")
        self._outputs = [
            diagram.GetOutputPort(name) for name in ("virtual", "impedance")
        ]
        self._WarmUp()

    def _WarmUp(self) -> None:
        """Laws are loaded at first calls, which no tick could wait for."""
        lengths = self._geometry.at(self._start)[0]
        at_rest = np.concatenate([lengths, np.zeros(3 * self._rings + 3)])
        self.Reset()
        for _ in range(3):
            self.Tick(at_rest, np.zeros((3, self._rings)))
        self.Reset()

    def Reset(self) -> None:
        """All states as at time 0, rings at the start: before any motion."""
        self._context.SetTime(0.0)
        self._simulator.get_system().SetDefaultContext(self._context)
        n = self._rings
        self._ticks, self._home = 0, 0
        self._memory = self._start_pose.reshape((n, -1)).copy()
        self._work = brace_control.take_work(n)
        self._poses, self._state = self._work[0:2]
        self._poses[:], self._state[:] = 0.0, 0.0
        self._away: np.ndarray | None = self._start
        self._virtual, self._impedance = np.zeros(18 * n), np.zeros(18 * n)
        self.command, self.good = np.array(self.hold), True

    def GoHome(self, ticks: int) -> None:
        """Lets the next ticks bring the rings to the start from anywhere.

        X_d goes there on the cubic of `laws.cubic`, from where they are found,
        so that rings that were pushed away come back softly.
        """
        self._away, self._home = None, ticks

    def Tick(self, readings: np.ndarray, desired: np.ndarray) -> np.ndarray:
        """Takes a tick's readings and reference; returns leg forces (n,), N.

        Args:
            readings: Lengths (n), forces (3 S), marker (3).
            desired: y_d, y_d', y_d'' of each ring, from the start (3, S).
        """
        n, held = 6 * self._rings, self.command.copy()
        self.good = estimate_rings(
            readings[0:n], self._rows, self._memory, self._poses, self._state,
            self._work[3],
        )  # fmt: skip
        V = self._state[1].reshape((-1, 6)).take(_ROTATION_FIRST, axis=1)
        calc_forces_left(
            self._poses, V, held, self._viscous, self._weights,
            self._geometry.lower, self._geometry.upper, self.expected,
        )  # fmt: skip
        if not self.good:
            return self.command
        if self._away is None:
            self._away = self._state[0].copy()
            self._controller.SetVirtual(
                self._controller.GetMyMutableContextFromRoot(self._context),
                self._away,
            )
        X_d = np.zeros(3 * n)
        X_d[0:n] = self._start
        if self._ticks < self._home:
            calc_cubic(
                self._ticks * self.period, self._home * self.period,
                self._away, self._start - self._away, X_d,
            )  # fmt: skip
        X_d[_ALONG::6] += np.ravel(desired)
        self._Advance(readings, X_d)
        self._ticks += 1
        return self.command

    def _Advance(self, readings: np.ndarray, X_d: np.ndarray) -> None:
        """A tick of the station on X_d, X_d', X_d'' (3 n,)."""
        self._device.SetReadings(self._own, readings)
        self._desired.FixValue(self._context, X_d)
        if self._ticks == 0:
            self._simulator.Initialize()
        # Beyond the tick, so that what decides now sees the readings of now.
        now = self._ticks * self.period
        self._simulator.AdvanceTo(now + 0.5 * TICK_LEAD)
        self.command[:] = self._device.EvalCommand(self._own)
        self._virtual, self._impedance = (
            port.Eval(self._context) for port in self._outputs
        )

    def Pass(self, command) -> None:
        """Tells what the legs were given in place of the last command."""
        self.command[:] = command

    @property
    def pose(self) -> list[float]:
        """X of the rings (n,)."""
        return self._state[0].tolist()

    @property
    def virtual(self) -> list[float]:
        """X_v of the rings (n,)."""
        return self._virtual[0 : 6 * self._rings].tolist()

    @property
    def y_ring(self) -> np.ndarray:
        """Displacement of each ring along y (S,), m."""
        return self._state[0, _ALONG::6].copy()

    @property
    def y_virtual(self) -> np.ndarray:
        """Virtual position of each ring along y (S,), m."""
        return self._virtual[_ALONG : 6 * self._rings : 6].copy()

    @property
    def stiffness(self) -> np.ndarray:
        """K_d along y in use, of each ring (S,), N/m."""
        return self._impedance[12 * self._rings + _ALONG :: 6].copy()

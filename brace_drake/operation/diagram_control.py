"""A controller of the brace as a diagram with a device in the plant's place."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from brace_drake.hardware.limits import Limits
from brace_drake.kinematics import holding_leg_forces
from brace_drake.laws import brace_control
from brace_drake.laws.cubic import calc_cubic
from brace_drake.laws.force_left import calc_forces_left
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_rings
from brace_drake.scenario.control_numbers import pack_control
from brace_drake.systems.brace_controller import BraceController
from brace_drake.systems.brace_controllers import MakeController
from brace_drake.systems.stiffness_limiter import StiffnessLimiter
from brace_drake.systems.ticks import TICK_LEAD

_ALONG = 1
# Places in a velocity [v; w] of task coordinates.
_ROTATION_FIRST = [3, 4, 5, 0, 1, 2]


def MakeHostDiagram(
    control: BraceController,
    stiffness: LeafSystem | None = None,
    limits: Limits | None = None,
    period: float = 1e-3,
) -> Diagram:
    """A controller and what sets its stiffness; the device is the plant.

    Args:
        control: With an input `stiffness` where something sets it.
        stiffness: With the ports of `learning.policy_systems.PolicySystem`:
            estimate and desired in, stiffness out; or None.
        limits: Of the stiffness and its rate, held behind `stiffness`.
        period: Of a tick, s.

    Input ports: leg_length, force, desired.
    Output ports: leg_command, virtual, impedance, estimate.
    """
    builder = DiagramBuilder()
    builder.AddNamedSystem("controller", control)
    for name in ("leg_length", "force", "desired"):
        builder.ExportInput(control.GetInputPort(name), name)
    for name in ("leg_command", "virtual", "impedance", "estimate"):
        builder.ExportOutput(control.GetOutputPort(name), name)
    if stiffness is not None:
        builder.AddNamedSystem("stiffness", stiffness)
        builder.ConnectInput("desired", stiffness.GetInputPort("desired"))
        limiter = builder.AddNamedSystem(
            "limiter",
            StiffnessLimiter(
                limits, control.GetInputPort("leg_length").size(), period
            ),
        )
        for source, port in (
            (
                control.GetOutputPort("estimate"),
                stiffness.GetInputPort("estimate"),
            ),
            (stiffness.GetOutputPort("stiffness"), limiter.get_input_port()),
            (limiter.get_output_port(), control.GetInputPort("stiffness")),
        ):
            builder.Connect(source, port)
    diagram = builder.Build()
    diagram.set_name("host")
    return diagram


class DiagramControl:
    """The host's control by such a diagram, tick by tick; see `PicControl`.

    Of a brace with S moving rings, n = 6 S coordinates.

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
        limits: Limits,
        stiffness: LeafSystem | None = None,
    ):
        """With the controller of the scenario.

        Args:
            scenario: Checked.
            limits: Of the stiffness and its rate.
            stiffness: What sets it, see `MakeHostDiagram`.

        Raises:
            ScenarioError: Numbers that are not allowed.
        """
        numbers, rings = pack_brace(scenario), pack_rings(scenario)
        self._geometry, self.period = (
            numbers.geometry,
            1.0 / scenario.control.rate,
        )
        n = numbers.num_stages
        self._rings, self._viscous = n, numbers.viscous
        self._weights = np.full(n, numbers.ring[4])
        held = holding_leg_forces(numbers.geometry, self._weights)
        self.hold = tuple(held.tolist())
        self._controller = MakeController(scenario.control, rings)
        control = pack_control(scenario.control, rings)
        self._law, self._start_pose = control.law, control.pose
        self._start = numbers.start
        self._diagram = MakeHostDiagram(
            self._controller, stiffness, limits, self.period
        )
        self._simulator = Simulator(self._diagram)
        self._context = self._simulator.get_mutable_context()
        # A callback finds its context's Python object faster than it makes one.
        self._contexts = [
            system.GetMyContextFromRoot(self._context)
            for system in self._diagram.GetSystems()
        ]
        self._inputs = [
            self._diagram.GetInputPort(name)
            for name in ("leg_length", "force", "desired")
        ]
        self._outputs = {
            name: self._diagram.GetOutputPort(name)
            for name in ("leg_command", "virtual", "impedance")
        }
        self.expected = np.zeros(3 * n)
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
        self._diagram.SetDefaultContext(self._context)
        n = self._rings
        self._ticks, self._home = 0, 0
        self._memory = self._start_pose.reshape((n, -1)).copy()
        self._poses, self._state = np.zeros((n, 7)), np.zeros((2, 6 * n))
        self._away: np.ndarray | None = self._start
        self._virtual, self._impedance = np.zeros(18 * n), np.zeros(18 * n)
        self.command, self.good = np.array(self.hold), True

    def GoHome(self, ticks: int) -> None:
        """Lets the next ticks bring the rings to the start from anywhere.

        X_d goes there on the cubic of `laws.cubic`, from where they are found.
        """
        self._away, self._home = None, ticks

    def Tick(self, readings: np.ndarray, desired: np.ndarray) -> np.ndarray:
        """Takes a tick's readings and reference; returns leg forces (n,), N.

        Args:
            readings: Lengths (n), forces (3 S), marker (3).
            desired: y_d, y_d', y_d'' of each ring, from the start (3, S).
        """
        n, held = 6 * self._rings, self.command.copy()
        self.good = brace_control.estimate_rings(
            readings[0:n], self._law, self._memory, self._poses, self._state
        )
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
        self._Advance((readings[0:n], readings[n:-3], X_d))
        return self.command

    def _Advance(self, values) -> None:
        for port, value in zip(self._inputs, values, strict=True):
            port.FixValue(self._context, value)
        now = self._ticks * self.period
        if self._ticks == 0:
            self._simulator.Initialize()
        # Beyond the tick, so that what decides now sees the readings of now.
        self._simulator.AdvanceTo(now + 0.5 * TICK_LEAD)
        self._ticks += 1
        self.command[:], self._virtual, self._impedance = (
            port.Eval(self._context) for port in self._outputs.values()
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

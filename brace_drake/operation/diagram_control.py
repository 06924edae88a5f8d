"""A controller of the brace as a diagram with a device in the plant's place."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from brace_drake.errors import ScenarioError
from brace_drake.hardware.limits import Limits
from brace_drake.kinematics import holding_leg_forces
from brace_drake.laws import controller
from brace_drake.laws.bench_observer import calc_force_left
from brace_drake.laws.brace_control import ESTIMATOR
from brace_drake.laws.cubic import calc_cubic
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_rings
from brace_drake.scenario.control_numbers import pack_control
from brace_drake.systems.brace_controller import BraceController
from brace_drake.systems.brace_controllers import MakeController
from brace_drake.systems.stiffness_limiter import StiffnessLimiter
from brace_drake.systems.ticks import TICK_LEAD

# Of the bench: the only moving ring of stage 2.
_STAGES, _ALONG = [2], 1


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

    Attributes:
        command: Leg commands of the last tick (6,), N.
        expected: What the legs left for the torso in it (3,), N.
        good: Whether a ring pose fitted the lengths.
        hold: Leg forces that carry the ring's weight at rest (6,), N.
        period: Of a tick, s.
    """

    def __init__(
        self,
        scenario: BraceScenario,
        limits: Limits,
        stiffness: LeafSystem | None = None,
    ):
        """Of stage 2 alone, with the controller of the scenario.

        Args:
            scenario: Checked.
            limits: Of the stiffness and its rate.
            stiffness: What sets it, see `MakeHostDiagram`.

        Raises:
            ScenarioError: Other stages, or numbers that are not allowed.
        """
        if scenario.stages != _STAGES:
            raise ScenarioError(
                f"stages is {scenario.stages}; allowed on the bench: {_STAGES}"
            )
        numbers, rings = pack_brace(scenario), pack_rings(scenario)
        geometry, self.period = numbers.geometry, 1.0 / scenario.control.rate
        self._weight = float(numbers.ring[4])
        self._anchors = (geometry.lower[0], geometry.upper[0])
        self._rest, self._viscous = geometry.rest[0], numbers.viscous
        held = holding_leg_forces(geometry, [self._weight])
        self.hold = tuple(held.tolist())
        law = pack_control(scenario.control, rings).law
        self._estimator = law[ESTIMATOR].copy()
        self._controller = MakeController(scenario.control, rings)
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
        self.expected = np.zeros(3)
        self._WarmUp(geometry.rest_lengths)

    def _WarmUp(self, lengths: np.ndarray) -> None:
        """Laws are loaded at first calls, which no tick could wait for."""
        self.Reset()
        for _ in range(3):
            self.Tick(np.array([*lengths, *np.zeros(6)]), np.zeros(3))
        self.Reset()

    def Reset(self) -> None:
        """All states as at time 0, ring at rest: as before any motion."""
        self._context.SetTime(0.0)
        self._diagram.SetDefaultContext(self._context)
        self._ticks, self._estimate = 0, np.zeros(19)
        self._pose = np.zeros(controller.NUM_POSE_MEMORY)
        self._pose[0:3], self._pose[3] = self._rest, 1.0
        self._away, self._home = np.zeros(6), 0
        self._virtual, self._impedance = np.zeros(18), np.zeros(18)
        self.command, self.good = np.array(self.hold), True

    def GoHome(self, ticks: int) -> None:
        """Lets the next ticks bring the ring to rest from where it is found.

        X_d goes there on the cubic of `laws.cubic`, from where the ring is.
        """
        self._away, self._home = None, ticks

    def Tick(self, readings: np.ndarray, desired: np.ndarray) -> np.ndarray:
        """Takes a tick's readings (12,) and y_d, y_d', y_d''; returns (6,)."""
        held = self.command.copy()
        self.good = controller.estimate_pose(
            readings[0:6], self._estimator, *self._anchors, self._pose,
            self._estimate,
        )  # fmt: skip
        calc_force_left(
            self._estimate, held, self._viscous, self._weight, *self._anchors,
            self.expected,
        )  # fmt: skip
        if not self.good:
            return self.command
        if self._away is None:
            self._away = self._estimate[0:6].copy()
            self._controller.SetVirtual(
                self._controller.GetMyMutableContextFromRoot(self._context),
                self._away,
            )
        X_d = np.zeros(18)
        if self._ticks < self._home:
            calc_cubic(
                self._ticks * self.period, self._home * self.period,
                self._away, -self._away, X_d,
            )  # fmt: skip
        X_d[_ALONG::6] += desired
        self._Advance((readings[0:6], readings[6:9], X_d))
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
        """X of the ring (6,)."""
        return self._estimate[0:6].tolist()

    @property
    def virtual(self) -> list[float]:
        """X_v of the ring (6,)."""
        return self._virtual[0:6].tolist()

    @property
    def y_virtual(self) -> float:
        """Virtual position along y, m."""
        return float(self._virtual[_ALONG])

    @property
    def stiffness(self) -> float:
        """K_d along y in use, N/m."""
        return float(self._impedance[12 + _ALONG])

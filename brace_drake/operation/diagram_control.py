"""A controller of the brace as a diagram with a device in the plant's place."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from brace_drake.hardware.limits import Limits
from brace_drake.operation.host_control import HostControl
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_rings
from brace_drake.scenario.control_numbers import pack_control
from brace_drake.systems.brace_controller import BraceController
from brace_drake.systems.brace_controllers import MakeController
from brace_drake.systems.stiffness_limiter import StiffnessLimiter
from brace_drake.systems.ticks import TICK_LEAD


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


class DiagramControl(HostControl):
    """The host's control by such a diagram, tick by tick."""

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
        self._controller = MakeController(scenario.control, rings)
        control = pack_control(scenario.control, rings)
        super().__init__(
            numbers.geometry, numbers.viscous, numbers.ring[4], control
        )
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
        self._WarmUp()

    def Reset(self) -> None:
        super().Reset()
        self._context.SetTime(0.0)
        self._diagram.SetDefaultContext(self._context)

    def _SetVirtual(self, X: np.ndarray) -> None:
        own = self._controller.GetMyMutableContextFromRoot(self._context)
        self._controller.SetVirtual(own, X)

    def _Advance(self, readings: np.ndarray, X_d: np.ndarray) -> None:
        n = 6 * self._rings
        values = readings[0:n], readings[n:-3], X_d
        for port, value in zip(self._inputs, values, strict=True):
            port.FixValue(self._context, value)
        if self._ticks == 0:
            self._simulator.Initialize()
        # Beyond the tick, so that what decides now sees the readings of now.
        now = self._ticks * self.period
        self._simulator.AdvanceTo(now + 0.5 * TICK_LEAD)
        self.command[:], self._virtual, self._impedance = (
            port.Eval(self._context) for port in self._outputs.values()
        )

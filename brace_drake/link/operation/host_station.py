"""The host's station: a device in the place of plant, drives, instruments."""

from __future__ import annotations

from dataclasses import dataclass

from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from brace_drake.link.device.limits import Limits
from brace_drake.model.brace_station import ConnectController
from brace_drake.model.systems.brace_controller import BraceController
from brace_drake.model.systems.device_station import DeviceStation
from brace_drake.model.systems.stiffness_limiter import StiffnessLimiter


@dataclass
class HostStation:
    """A built station: the diagram, and the device in it.

    The controller is connected as in the stations of simulation. Exported
    ports of the diagram: input `desired` (18 S,); outputs `leg_command`,
    `virtual`, `impedance`, `estimate` of the controller.
    """

    diagram: Diagram
    device: DeviceStation


def MakeHostStation(
    controller: BraceController,
    num_rings: int,
    period: float,
    stiffness: LeafSystem | None = None,
    limits: Limits | None = None,
) -> HostStation:
    """Builds a station around a controller.

    Args:
        controller: With an input `stiffness` where something sets it.
        num_rings: S, of the device.
        period: Of a tick, s.
        stiffness: With the ports of `learning.deployment.PolicySystem`:
            estimate and desired in, stiffness out; or None.
        limits: Of the stiffness and its rate, held behind `stiffness`.
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
    return HostStation(diagram, device)

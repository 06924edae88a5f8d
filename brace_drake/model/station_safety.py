"""The safety supervisor between a station's controller and its drives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import Demultiplexer

from brace_drake.kinematics import holding_leg_forces
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.systems.leg_force_balance import LegForceBalance
from brace_drake.model.systems.safety_supervisor import SafetySupervisor
from brace_drake.scenario.control_numbers import BraceRings

NAME = "supervisor"


@dataclass(frozen=True)
class Supervision:
    """What a supervisor is to hold, and what it knows.

    Attributes:
        limits: To be held.
        rings: As the controller knows them.
        viscous: Of each leg (6 S,), N s/m.
        period: Of a tick, s.
    """

    limits: Limits
    rings: BraceRings
    viscous: np.ndarray
    period: float


def AddSupervisor(
    builder: DiagramBuilder,
    supervision: Supervision,
    readings: dict[str, OutputPort],
    controller: dict[str, OutputPort],
    drives: System,
) -> None:
    """Adds a supervisor, armed from the start, in front of the drives.

    Args:
        builder: Of the station.
        supervision: What it holds.
        readings: `leg_length` and `force`.
        controller: Outputs of a controller.
        drives: What takes the commands that pass.
    """
    rings, n = supervision.rings, 6 * supervision.rings.num_rings
    weights = rings.mass[:, 0] * rings.gravity
    hold = holding_leg_forces(rings.geometry, weights).tolist()
    supervisor = builder.AddNamedSystem(
        NAME, SafetySupervisor(supervision.limits, hold, supervision.period)
    )
    passed = supervisor.GetOutputPort("leg_command")
    builder.Connect(passed, drives.get_input_port())
    balance = builder.AddNamedSystem(
        "leg_force_balance",
        LegForceBalance(rings.geometry, supervision.viscous, weights),
    )
    builder.Connect(controller["estimate"], balance.GetInputPort("estimate"))
    builder.Connect(passed, balance.GetInputPort("leg_command"))
    seen = {
        "leg_command": controller["leg_command"],
        "leg_length": readings["leg_length"],
        "force": readings["force"],
        "expected_force": balance.get_output_port(),
        "pose": _First(builder, controller["estimate"], "pose", n),
        "virtual_pose": _First(
            builder, controller["virtual"], "virtual_pose", n
        ),
    }
    for name, port in seen.items():
        builder.Connect(port, supervisor.GetInputPort(name))


def _First(
    builder: DiagramBuilder, port: OutputPort, name: str, size: int
) -> OutputPort:
    """The first values of a port."""
    split = Demultiplexer([size, port.size() - size])
    split = builder.AddNamedSystem(f"supervised_{name}", split)
    builder.Connect(port, split.get_input_port())
    return split.get_output_port(0)

"""A device on a link where the diagrams of simulation have their brace."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context, LeafSystem


class DeviceStation(LeafSystem):
    """A physical brace of n moving rings, with the ports of a brace station.

    What stands outside passes on readings as they come and fetches commands.

    Input ports:
        leg_command: What the legs shall do (6n,), N.

    Output ports, as last read:
        leg_length: (6n,), m.
        force: Of each ring on the torso in W (3n,), N.
        marker: The torso's displacement (3,), m.
    """

    def __init__(self, num_rings: int):
        super().__init__()
        n = num_rings
        self._command = self.DeclareVectorInputPort("leg_command", 6 * n)
        self._readings = []
        for name, size in (
            ("leg_length", 6 * n),
            ("force", 3 * n),
            ("marker", 3),
        ):
            state = self.DeclareDiscreteState(size)
            self.DeclareStateOutputPort(name, state)
            self._readings.append((int(state), size))

    def SetReadings(self, context: Context, readings: np.ndarray) -> None:
        """Takes lengths (6n), forces (3n) and marker (3), one after another."""
        at = 0
        for state, size in self._readings:
            values = readings[at : at + size]
            context.get_mutable_discrete_state(state).SetFromVector(values)
            at += size

    def EvalCommand(self, context: Context) -> np.ndarray:
        """What is asked of the legs (6n,), N."""
        return self._command.Eval(context)

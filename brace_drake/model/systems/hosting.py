"""How a LeafSystem hosts the effects that sit at its plug points."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws.plug_in import PlugIn


class EffectHost:
    """Parameters and states of one plug point, kept in a system's Context.

    Parameters of each effect become a numeric parameter; states of each, where
    the point is not idle, a discrete state group that the host's own update
    advances.
    """

    def __init__(self, system: LeafSystem, plug_in: PlugIn):
        self.is_idle = plug_in.is_idle
        self._laws = plug_in.laws
        self._parameters = []
        self._states = []
        if self.is_idle:
            return
        for parameters, initial in zip(
            plug_in.parameters, plug_in.initial, strict=True
        ):
            self._parameters.append(
                int(system.DeclareNumericParameter(BasicVector(parameters)))
            )
            self._states.append(int(system.DeclareDiscreteState(initial)))

    def apply(
        self, context: Context, memory: tuple[np.ndarray, ...], *arguments
    ) -> None:
        """Calls each effect's law on the arguments, then p and x."""
        if self.is_idle:
            return
        for law, i, x in zip(self._laws, self._parameters, memory, strict=True):
            p = context.get_numeric_parameter(i).CopyToVector()
            law(*arguments, p, x)

    def memory(self, context: Context) -> tuple[np.ndarray, ...]:
        """Copies of the effects' states, free to be advanced."""
        return tuple(
            context.get_discrete_state(i).CopyToVector() for i in self._states
        )

    def store(self, memory: tuple[np.ndarray, ...], discrete) -> None:
        """Writes advanced states into discrete values."""
        for i, x in zip(self._states, memory, strict=True):
            discrete.get_mutable_vector(i).SetFromVector(x)

"""The effects on the forces of a brace, as a system's parameters and states."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws.plug_in import PlugIn, make_effects


class ForceEffects:
    """Effects at drive, compression, contact, torso and ring.

    Declares on a LeafSystem, whose constructor is running, a numeric parameter
    for each effect and a discrete state for each that has any at a plug point,
    all stages one after another.

    Attributes:
        effects: As `laws.loop.forces` takes them, see `load`.
        is_nominal: Whether there is none.
    """

    def __init__(
        self,
        system: LeafSystem,
        plug_ins: Mapping[str, PlugIn],
        num_stages: int,
    ):
        plug_ins = {p: plug for p, plug in plug_ins.items() if p != "sensing"}
        self.effects = effects = make_effects(plug_ins, num_stages)
        self.is_nominal = not effects.active.any()
        self._parameters: list[tuple[int, np.ndarray]] = []
        self._states: list[tuple[int, np.ndarray]] = []
        for e in np.flatnonzero(effects.active.any(axis=0)):
            values = effects.parameters_of(e)
            index = system.DeclareNumericParameter(BasicVector(values))
            self._parameters.append((int(index), values))
            for point in np.flatnonzero(effects.active[:, e]):
                values = effects.memory_of(point, e)
                index = system.DeclareDiscreteState(values)
                self._states.append((int(index), values))

    def load(self, context: Context) -> None:
        """Fills in parameters and states of a context."""
        for index, values in self._parameters:
            values[:] = context.get_numeric_parameter(index).value()
        for index, values in self._states:
            values[:] = context.get_discrete_state(index).value()

    def store(self, discrete) -> None:
        """Writes states, as they are now, into discrete values."""
        for index, values in self._states:
            discrete.get_mutable_vector(index).SetFromVector(values)

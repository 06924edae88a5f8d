"""How a LeafSystem hosts the effects that sit at its plug points."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws.plug_in import PlugIn


class EffectHost:
    """Parameters and states of one plug point, kept in a system's Context.

    Parameters of each effect become a numeric parameter; states of each, where
    the point is not idle, a discrete state group that the host's own update
    advances. Of several stages there is a part for each, one after another.
    """

    def __init__(
        self, system: LeafSystem, plug_in: PlugIn, num_stages: int = 1
    ):
        self.is_idle = plug_in.is_idle
        self._laws, self._num_stages = plug_in.laws, num_stages
        self._parameters = []
        self._states = []
        if self.is_idle:
            return
        for parameters, initial in zip(
            plug_in.parameters, plug_in.initial, strict=True
        ):
            shape = num_stages, parameters.shape[-1]
            values = BasicVector(np.broadcast_to(parameters, shape).ravel())
            self._parameters.append(int(system.DeclareNumericParameter(values)))
            states = np.tile(initial, num_stages)
            self._states.append(int(system.DeclareDiscreteState(states)))

    def apply(
        self,
        context: Context,
        memory: tuple[np.ndarray, ...],
        *arguments,
        stage: int = 0,
    ) -> None:
        """Calls each effect's law on the arguments of a stage, then p and x."""
        if self.is_idle:
            return
        for law, i, x in zip(self._laws, self._parameters, memory, strict=True):
            p = context.get_numeric_parameter(i).CopyToVector()
            p = p.reshape((self._num_stages, -1))[stage]
            law(*arguments, p, x.reshape((self._num_stages, -1))[stage])

    def read(
        self, context: Context, memory: tuple, times: tuple, u, readings
    ) -> None:
        """Lets effects at `sensing` of all stages change readings.

        Args:
            context, memory: As in `apply`.
            times: Now, and period, s.
            u: Held commands (6 S,), N.
            readings: Lengths (6 S), m, and forces (3 S), N, changed.
        """
        n = self._num_stages
        for i in range(n):
            a, b, at = 6 * i, 6 * i + 6, 6 * n + 3 * i
            self.apply(
                context, memory, *times, u[a:b], readings[a:b],
                readings[at : at + 3], stage=i,
            )  # fmt: skip

    def memory(self, context: Context) -> tuple[np.ndarray, ...]:
        """Copies of the effects' states, free to be advanced."""
        return tuple(
            context.get_discrete_state(i).CopyToVector() for i in self._states
        )

    def store(self, memory: tuple[np.ndarray, ...], discrete) -> None:
        """Writes advanced states into discrete values."""
        for i, x in zip(self._states, memory, strict=True):
            discrete.get_mutable_vector(i).SetFromVector(x)

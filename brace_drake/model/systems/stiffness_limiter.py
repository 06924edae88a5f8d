"""Bounds and rate of a desired stiffness, whoever asks for it."""

from __future__ import annotations

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.link.device.release import cut_stiffness
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.systems.ticks import TICK_LEAD


class StiffnessLimiter(LeafSystem):
    """Passes a stiffness within limits: `link.device.release.cut_stiffness`.

    It ticks right before the controller does, so that what passes acts in the
    controller's own tick. What is no number keeps the last value.

    Input ports:
        stiffness: K_d asked for (6n,), N/m and N m/rad.

    Output ports:
        stiffness: What passes (6n,), held from the last tick; before the first
            one the input within the bounds, as no rate holds yet.
    """

    def __init__(self, limits: Limits, coordinates: int, period: float):
        super().__init__()
        self._limits, self._period = limits, period
        self._asked = self.DeclareVectorInputPort("stiffness", coordinates)
        self._held = int(self.DeclareDiscreteState(coordinates))
        self.DeclareVectorOutputPort("stiffness", coordinates, self._Calc)
        self.DeclareInitializationDiscreteUpdateEvent(self._Tick)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period, period - 2.0 * TICK_LEAD, self._Tick
        )

    def _Cut(self, context: Context) -> tuple[float, ...]:
        held = context.get_discrete_state(self._held).value()
        asked = self._asked.Eval(context)
        return cut_stiffness(
            self._limits, held.tolist(), asked.tolist(), self._period
        )

    def _Tick(self, context: Context, discrete) -> None:
        discrete.set_value(self._held, self._Cut(context))

    def _Calc(self, context: Context, output: BasicVector) -> None:
        held = context.get_discrete_state(self._held).value()
        output.SetFromVector(held if held.any() else self._Cut(context))

"""Decisions of a policy in a diagram: held actions, bounds, observations."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.learning.actions import ActionLaw
from brace_drake.learning.policy import Policy
from brace_drake.learning.signals import (
    OBSERVERS,
    observation_size,
    signals_of_estimate,
)


class StiffnessHold(LeafSystem):
    """Actions from outside, held between decisions, as stiffness.

    At each decision a+ = a + cut(cut(action) - a) within `law.largest`; K(a)
    lies within the law's bounds whatever comes (`actions.ActionLaw`).

    Input ports:
        action: (k,), -1 to 1; read at decisions alone.

    Output ports:
        stiffness: Of all coordinates (6n,), N/m, 0 where there is none.
        held_action: (k,).
    """

    def __init__(self, law: ActionLaw, selected: np.ndarray, period: float):
        super().__init__()
        self._law, self._selected = law, selected
        self._DeclareInputs(len(law.start))
        held = self.DeclareDiscreteState(law.action(law.start))
        self.DeclareVectorOutputPort(
            "stiffness",
            len(selected),
            self._CalcStiffness,
            prerequisites_of_calc={self.discrete_state_ticket(held)},
        )
        self.DeclareStateOutputPort("held_action", held)
        self._held = int(held)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._Decide)

    def _DeclareInputs(self, size: int) -> None:
        self._action_port = self.DeclareVectorInputPort("action", size)

    def _AskAction(self, context: Context) -> np.ndarray:
        return self._action_port.Eval(context)

    def _Decide(self, context: Context, discrete) -> None:
        before = context.get_discrete_state(self._held).CopyToVector()
        action = self._law.limit(self._AskAction(context), before)
        discrete.set_value(self._held, action)

    def _CalcStiffness(self, context: Context, output: BasicVector) -> None:
        held = context.get_discrete_state(self._held).value()
        stiffness = np.zeros(len(self._selected))
        stiffness[self._selected] = self._law.stiffness(held)
        output.SetFromVector(stiffness)


class Observer(LeafSystem):
    """What a policy sees.

    Input ports:
        estimate: X, X', filtered force (18n,), as the controller has it.
        desired: X_d, X_d', X_d'' (18n,).

    Output ports:
        observation: See `signals.OBSERVERS`.
    """

    def __init__(self, kind: str, coordinates: int):
        super().__init__()
        self._observe = OBSERVERS[kind]
        self._ports = [
            self.DeclareVectorInputPort(name, 3 * coordinates)
            for name in ("estimate", "desired")
        ]
        self.DeclareVectorOutputPort(
            "observation", observation_size(kind, coordinates), self._Calc
        )

    def _Calc(self, context: Context, output: BasicVector) -> None:
        estimate, desired = (port.Eval(context) for port in self._ports)
        signals = signals_of_estimate(estimate, desired)
        output.SetFromVector(self._observe(signals))


class PolicySystem(StiffnessHold):
    """A policy that sets the stiffness of `BraceVpic`: RLPIC at run time.

    At each decision the network acts on what the controller knew at its last
    tick; bounds and rate limit are `StiffnessHold`'s, outside of the network.

    Input ports:
        estimate: X, X', filtered force (18n,), of the controller.
        desired: X_d, X_d', X_d'' (18n,).

    Output ports: as `StiffnessHold`.
    """

    def __init__(self, policy: Policy):
        self._policy = policy
        super().__init__(policy.law, policy.selected, policy.task.sample_time)

    def _DeclareInputs(self, size: int) -> None:
        width = 3 * len(self._policy.selected)
        self._estimate_port = self.DeclareVectorInputPort("estimate", width)
        self._desired_port = self.DeclareVectorInputPort("desired", width)

    def _AskAction(self, context: Context) -> np.ndarray:
        return self._policy.act_on(
            self._estimate_port.Eval(context), self._desired_port.Eval(context)
        )

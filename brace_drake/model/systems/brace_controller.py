"""What all controllers of the brace share: ports, state, and their tick."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.core.errors import BraceError
from brace_drake.laws.control import brace_control
from brace_drake.laws.control.pose_estimate import NUM_POSE_MEMORY
from brace_drake.model.systems.ticks import DeclareTick
from brace_drake.scenario.control_numbers import ControlNumbers

_BY_RULE = np.empty(0)
PROBLEMS = {
    brace_control.NO_POSE: "no ring pose fits the measured leg lengths",
    brace_control.SINGULAR: "the leg Jacobian is singular",
    brace_control.BAD_STIFFNESS: "a stiffness asked for is not a number",
}


def estimate_of_memory(
    pose: np.ndarray, force: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """X, X' and filtered force (18n,) from a controller's memory.

    Args:
        pose: Of the estimators (20n,), see `pose_estimate.NUM_POSE_MEMORY`.
        force: Filtered (6n,).
        start: X before the first tick (6n,).
    """
    memory = pose.reshape(-1, NUM_POSE_MEMORY)
    X = memory[:, 7:13].ravel() if memory[0, 19] else start
    return np.concatenate([X, memory[:, 13:19].ravel(), force])


class BraceController(LeafSystem):
    """A controller of n moving rings, the whole tick in one event.

    Base of the controllers in `brace_controllers`; the law of a tick is
    `brace_drake.laws.control.brace_control.advance_brace`.

    Input ports:
        leg_length: Measured (6n,), m.
        force: Measured force of each ring on the torso in W (3n,), N.
        desired: X_d, X_d', X_d'' (18n,).

    Output ports, of the last tick:
        leg_command: (6n,), N.
        virtual: X_v, X_v', X_v'' (18n,).
        impedance: M_d, C_d, K_d in use (18n,), 0 where there is none.
        estimate: What the tick knew: X, X', and the filtered force (18n,).

    Numeric parameters: law, the rows of `advance_brace` one after another.

    Raises (at a tick):
        BraceError: The legs have no pose or are singular, or a stiffness asked
            for is not a number.
    """

    TAG = ""

    def __init__(self, numbers: ControlNumbers):
        super().__init__()
        self._kind, self._period = numbers.kind, numbers.period
        self._rows, coordinates = numbers.law.shape
        self._memory_shape = numbers.memory.shape
        self._DeclarePorts(coordinates)
        self._law = int(
            self.DeclareNumericParameter(BasicVector(numbers.law.ravel()))
        )
        self._groups = [
            int(self._DeclareHeld(name, values))
            for name, values in (
                ("virtual", numbers.virtual),
                ("impedance", np.zeros(3 * coordinates)),
                ("leg_command", np.zeros(coordinates)),
                ("", numbers.pose),
                ("", numbers.memory.ravel()),
            )
        ]
        self._start = numbers.virtual[0:coordinates]
        self.DeclareVectorOutputPort(
            "estimate",
            3 * coordinates,
            self._CalcEstimate,
            prerequisites_of_calc={self.xd_ticket()},
        )
        DeclareTick(self, self._period, self._Tick)

    def _DeclarePorts(self, coordinates: int) -> None:
        declare = self.DeclareVectorInputPort
        self._length_port = declare("leg_length", coordinates)
        self._force_port = declare("force", coordinates // 2)
        self._desired_port = declare("desired", 3 * coordinates)

    def SetVirtual(self, context: Context, X: np.ndarray) -> None:
        """Lets the virtual poses (6n,) begin elsewhere, at rest."""
        virtual = context.get_mutable_discrete_state(self._groups[0])
        virtual.SetFromVector(np.concatenate([X, np.zeros(2 * len(X))]))

    def _DeclareHeld(self, name: str, values: np.ndarray):
        state = self.DeclareDiscreteState(values)
        if name:
            self.DeclareStateOutputPort(name, state)
        return state

    def _CalcEstimate(self, context: Context, output: BasicVector) -> None:
        pose, memory = (
            context.get_discrete_state(i).value() for i in self._groups[3:5]
        )
        output.SetFromVector(
            estimate_of_memory(pose, memory[0 : len(self._start)], self._start)
        )

    def _AskedStiffness(self, context: Context) -> np.ndarray:
        """Stiffness from outside, or none."""
        return _BY_RULE

    def _Tick(self, context: Context, discrete) -> None:
        # Discrete values start as those of the context: the last tick's.
        virtual, impedance, command, pose, memory = (
            discrete.get_mutable_value(i) for i in self._groups
        )
        readings = np.concatenate(
            [self._length_port.Eval(context), self._force_port.Eval(context)]
        )
        law = context.get_numeric_parameter(self._law).CopyToVector()
        result = brace_control.advance_brace(
            self._kind,
            law.reshape((self._rows, -1)),
            (pose, memory.reshape(self._memory_shape), virtual, impedance),
            readings,
            self._desired_port.Eval(context),
            self._AskedStiffness(context),
            command,
        )
        if result != brace_control.GOOD:
            raise BraceError(
                f"{type(self).__name__}: {PROBLEMS[result]}"
                f" at {context.get_time():.3f} s"
            )

"""The brace's controller in blocks: estimator, impedance, inverse dynamics.

All are evaluated at a tick from what they remembered before it, so that a
chain of them acts without delay; then their memories advance together.
"""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.errors import BraceError
from brace_drake.laws import controller
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.ticks import DeclareTick


class PoseEstimator(LeafSystem):
    """Ring pose and velocity from leg lengths by forward kinematics.

    X is the pose whose legs, with the anchors as the controller knows them,
    have the measured lengths (Newton's method); X' its backward difference
    through a first-order low pass with gain 1 - exp(-2 pi f_c h).

    Input ports:
        leg_length: Measured (6,), m.

    Output ports:
        estimated_state: X (position, rotation vector) (6), X' (6), p_WR (3),
            q_WR (4): (19,).

    Numeric parameters: law (5,) rest position, period, velocity gain; p_WB
    (18,), p_RT (18,), m.
    """

    def __init__(self, numbers: BenchNumbers):
        super().__init__()
        self._length_port = self.DeclareVectorInputPort("leg_length", 6)
        self._law, self._p_WB, self._p_RT = (
            int(self.DeclareNumericParameter(BasicVector(np.ravel(a))))
            for a in (
                numbers.estimator,
                numbers.p_WB_known,
                numbers.p_RT_known,
            )
        )
        memory = np.zeros(controller.NUM_POSE_MEMORY)
        memory[0:3], memory[3] = numbers.rest, 1.0
        self._memory = self.DeclareDiscreteState(memory)
        self._output = self.DeclareVectorOutputPort(
            "estimated_state", 19, self._CalcEstimate
        )
        DeclareTick(self, numbers.estimator[3], self._Advance)
        self._estimate = np.empty(19)

    def _CalcEstimate(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).CopyToVector()
        good = controller.estimate_pose(
            self._length_port.Eval(context),
            context.get_numeric_parameter(self._law).CopyToVector(),
            context.get_numeric_parameter(self._p_WB)
            .CopyToVector()
            .reshape(6, 3),
            context.get_numeric_parameter(self._p_RT)
            .CopyToVector()
            .reshape(6, 3),
            memory,
            self._estimate,
        )
        if not good:
            raise BraceError(
                "PoseEstimator: no ring pose has the measured leg lengths"
                f" at {context.get_time():.3f} s"
            )
        output.SetFromVector(self._estimate)

    def _Advance(self, context: Context, discrete) -> None:
        estimate = self._output.Eval(context)
        discrete.get_mutable_vector(self._memory).SetFromVector(
            np.concatenate([estimate[12:19], estimate[0:12], [1.0]])
        )


class ImpedanceFilter(LeafSystem):
    """Virtual position along y from reference and force, equations (4), (5).

    M_d y_v'' + C_d y_v' + K_d y_v = M_d y_d'' + C_d y_d' + K_d y_d - F, with F
    the measured force of the brace on the torso through a low pass.

    Input ports:
        desired: y_d, y_d', y_d'' (3,).
        force: Measured force on the torso in W (3,), N.

    Output ports:
        virtual: Filtered force, y_v, y_v', y_v'' after the update of the tick
            at hand (4,).
        held_virtual: The same as of the last tick.

    Numeric parameters: law (5,) M_d, C_d, K_d, force gain, period. For any
    positive M_d, C_d, K_d the filter is passive from force to velocity.
    """

    def __init__(self, numbers: BenchNumbers):
        super().__init__()
        self._desired_port = self.DeclareVectorInputPort("desired", 3)
        self._force_port = self.DeclareVectorInputPort("force", 3)
        self._law = int(
            self.DeclareNumericParameter(BasicVector(numbers.impedance))
        )
        self._memory = self.DeclareDiscreteState(
            controller.NUM_IMPEDANCE_MEMORY
        )
        self._output = self.DeclareVectorOutputPort(
            "virtual", 4, self._CalcVirtual
        )
        self.DeclareStateOutputPort("held_virtual", self._memory)
        DeclareTick(self, numbers.impedance[4], self._Advance)

    def _CalcVirtual(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).CopyToVector()
        controller.filter_impedance(
            self._force_port.Eval(context)[1],
            self._desired_port.Eval(context),
            context.get_numeric_parameter(self._law).CopyToVector(),
            memory,
        )
        output.SetFromVector(memory)

    def _Advance(self, context: Context, discrete) -> None:
        discrete.get_mutable_vector(self._memory).SetFromVector(
            self._output.Eval(context)
        )


class BraceInverseDynamics(LeafSystem):
    """Leg commands by inverse dynamics in the task space, equation (6).

    F = M (X_v'' + K_D (X_v' - X') + K_P (X_v - X)) + G + F_e, f = J^-T F at
    the estimated pose, each leg limited. Not Drake's InverseDynamics, which
    works in joint space on a tree: here the six legs close loops.

    Input ports:
        estimated_state: From PoseEstimator (19,).
        virtual: From ImpedanceFilter (4,).

    Output ports:
        command: f (6,), N.

    Numeric parameters: law (10,) kp, kd, diagonal of M (6), weight, limit;
    p_WB (18,), p_RT (18,), m.
    """

    def __init__(self, numbers: BenchNumbers):
        super().__init__()
        self._state_port = self.DeclareVectorInputPort("estimated_state", 19)
        self._virtual_port = self.DeclareVectorInputPort("virtual", 4)
        self._law, self._p_WB, self._p_RT = (
            int(self.DeclareNumericParameter(BasicVector(np.ravel(a))))
            for a in (
                numbers.inverse_dynamics,
                numbers.p_WB_known,
                numbers.p_RT_known,
            )
        )
        self.DeclareVectorOutputPort("command", 6, self._CalcCommand)
        self._command = np.empty(6)

    def _CalcCommand(self, context: Context, output: BasicVector) -> None:
        regular = controller.calc_leg_commands(
            self._state_port.Eval(context),
            self._virtual_port.Eval(context),
            context.get_numeric_parameter(self._law).CopyToVector(),
            context.get_numeric_parameter(self._p_WB)
            .CopyToVector()
            .reshape(6, 3),
            context.get_numeric_parameter(self._p_RT)
            .CopyToVector()
            .reshape(6, 3),
            self._command,
        )
        if not regular:
            raise BraceError(
                "BraceInverseDynamics: the leg Jacobian is singular at"
                f" {context.get_time():.3f} s"
            )
        output.SetFromVector(self._command)


class TickHold(LeafSystem):
    """Holds what a tick computed and what it read until the next tick.

    Input ports:
        command: (6,), N.
        readings: (12,).

    Output ports:
        leg_command, readings: The same as of the last tick.
    """

    def __init__(self, period: float):
        super().__init__()
        self._held = []
        for name, output, size in (
            ("command", "leg_command", 6),
            ("readings", "readings", 12),
        ):
            port = self.DeclareVectorInputPort(name, size)
            state = self.DeclareDiscreteState(size)
            self.DeclareStateOutputPort(output, state)
            self._held.append((port, state))
        DeclareTick(self, period, self._Advance)

    def _Advance(self, context: Context, discrete) -> None:
        for port, state in self._held:
            discrete.get_mutable_vector(state).SetFromVector(port.Eval(context))

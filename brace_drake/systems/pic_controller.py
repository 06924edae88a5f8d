"""Position-based impedance control of one ring, the whole tick in one event."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.errors import BraceError
from brace_drake.laws import controller
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.ticks import DeclareTick


class PicController(LeafSystem):
    """PIC: equations (4), (5) outside, inverse dynamics (6) inside.

    PoseEstimator, ImpedanceFilter, BraceInverseDynamics and TickHold of
    `controller_blocks` run as one event, with the same laws and to the same
    result, at a fraction of their cost.

    Input ports:
        readings: Leg lengths (6), m, force (3), N, marker (3), m.
        desired: y_d, y_d', y_d'' (3,).

    Output ports, all of the last tick and held until the next:
        leg_command: (6,), N.
        readings: As they were used (12,).
        memory: p_WR (3), q_WR (4), X (6), X' (6), 1, filtered force, y_v,
            y_v', y_v'' (24,).

    Numeric parameters: law (56,), see `laws.controller`.
    """

    def __init__(self, numbers: BenchNumbers):
        super().__init__()
        self._readings_port = self.DeclareVectorInputPort("readings", 12)
        self._desired_port = self.DeclareVectorInputPort("desired", 3)
        self._law = int(
            self.DeclareNumericParameter(BasicVector(numbers.controller_law))
        )
        initial = np.zeros(controller.NUM_MEMORY)
        initial[0:3], initial[3] = numbers.rest, 1.0
        self._memory = self.DeclareDiscreteState(initial)
        self._command = self.DeclareDiscreteState(6)
        self._readings = self.DeclareDiscreteState(12)
        self.DeclareStateOutputPort("leg_command", self._command)
        self.DeclareStateOutputPort("readings", self._readings)
        self.DeclareStateOutputPort("memory", self._memory)
        DeclareTick(self, numbers.estimator[3], self._Tick)
        self._estimate, self._u = np.empty(19), np.empty(6)

    def _Tick(self, context: Context, discrete) -> None:
        readings = self._readings_port.Eval(context)
        memory = context.get_discrete_state(self._memory).CopyToVector()
        good = controller.control_tick(
            readings,
            self._desired_port.Eval(context),
            context.get_numeric_parameter(self._law).value(),
            memory,
            self._estimate,
            self._u,
        )
        if not good:
            raise BraceError(
                "PicController: no ring pose fits the measured leg lengths"
                f" at {context.get_time():.3f} s"
            )
        discrete.get_mutable_vector(self._memory).SetFromVector(memory)
        discrete.get_mutable_vector(self._command).SetFromVector(self._u)
        discrete.get_mutable_vector(self._readings).SetFromVector(readings)

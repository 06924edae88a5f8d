"""A plain servo of the brace, for tests of the mechanics under it."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from brace_drake.laws import stage_poses, stages
from brace_drake.model.systems.ticks import DeclareTick
from brace_drake.scenario.brace_numbers import geometry_of


class BraceServo(LeafSystem):
    """Leg forces that carry the rings and pull them to X_d.

    W = M (kp (X_d - X) - kd X') + weight, f = J^-T W, with X by forward
    kinematics and X' its backward difference. The controllers' ports.
    """

    def __init__(self, numbers, period=1e-3, kp=1600.0, kd=80.0):
        super().__init__()
        self.numbers, self.period, self.gains = numbers, period, (kp, kd)
        n = self.n = numbers.num_stages
        declare = self.DeclareVectorInputPort
        self.length = declare("leg_length", 6 * n)
        declare("force", 3 * n)
        self.desired = declare("desired", 18 * n)
        poses = np.empty((n, 7))
        stages.place_rings(numbers.start, numbers.rest, poses)
        self.DeclareDiscreteState(poses.ravel())
        self.DeclareDiscreteState(numbers.start)
        for name, size in (
            ("leg_command", 6),
            ("virtual", 18),
            ("impedance", 18),
        ):
            state = self.DeclareDiscreteState(size * n)
            self.DeclareStateOutputPort(name, state)
        self.mass = numbers.ring[:, [0, 0, 0, 1, 2, 3]].ravel()
        self.weight = np.zeros(6 * n)
        self.weight[2::6] = numbers.ring[:, 4]
        self.R, self.p_WB = np.empty((n, 3, 3)), np.empty((n, 6, 3))
        self.J, self.J_L = np.empty((n, 6, 6)), np.zeros((n, 6, 6))
        DeclareTick(self, period, self.Tick)

    def Tick(self, context, discrete):
        geometry, n = geometry_of(self.numbers), self.n
        poses = discrete.get_mutable_value(0).reshape(n, 7)
        lengths, X = np.empty(6 * n), np.empty(6 * n)
        at = geometry.lower, geometry.upper
        found = stage_poses.solve_poses(
            self.length.Eval(context), *at, geometry.rest, False, poses
        )
        assert found < 0
        stages.calc_task_coordinates(poses, geometry.rest, X)
        stages.calc_kinematics(
            poses, *at, self.R, self.p_WB, lengths, self.J, self.J_L
        )
        rate = (X - discrete.value(1)) / self.period
        discrete.set_value(1, X)
        kp, kd = self.gains
        error = self.desired.Eval(context)[: 6 * n] - X
        W = self.mass * (kp * error - kd * rate) + self.weight
        f = discrete.get_mutable_value(2)
        stages.solve_leg_forces(self.J, self.J_L, W, np.empty((6, 6)), f)

"""Blocks of a brace run by what was recorded, row by row."""

import numpy as np

from brace_drake.laws import stages
from brace_drake.laws.compiled import compiled_maker
from brace_drake.laws.control.brace_control import (
    advance_controller,
    make_controller,
)
from brace_drake.laws.legs import solve_forward_kinematics
from brace_drake.laws.loop.rollout import place_desired


@compiled_maker
def calc_poses(lengths, numbers, X, jacobians):
    """Task coordinates of leg lengths, and Jacobians.

    Args:
        lengths: l (N, 6n), m.
        numbers: Of the brace, see `laws.numbers`.
        X: Takes the task coordinates of the rings (N, 6n).
        jacobians: Takes the rates of the lengths by the rings' [v; w]
            (N, 6n, 6n).
    """
    n, nc = len(numbers.rest), lengths.shape[1]
    R, p_WB, at = np.empty((n, 3, 3)), np.empty((n, 6, 3)), np.empty(nc)
    J, J_L, poses = np.empty((n, 6, 6)), np.empty((n, 6, 6)), np.empty((n, 7))
    stages.place_rings(np.zeros(nc), numbers.rest, poses)
    jacobians[:] = 0.0
    for row in range(len(lengths)):
        for i in range(n):
            # Where the rings below are by now.
            stages.calc_kinematics(
                poses, numbers.lower, numbers.upper, R, p_WB, at, J, J_L
            )
            solve_forward_kinematics(
                lengths[row, 6 * i : 6 * i + 6], p_WB[i], numbers.upper[i],
                poses[i, 4:7], poses[i, 0:4],
            )  # fmt: skip
        stages.calc_task_coordinates(poses, numbers.rest, X[row])
        stages.calc_kinematics(
            poses, numbers.lower, numbers.upper, R, p_WB, at, J, J_L
        )
        for i in range(n):
            a, b = 6 * i, 6 * i + 6
            jacobians[row, a:b, a:b] = J[i]
            if i > 0:
                jacobians[row, a:b, a - 6 : a] = J_L[i]


@compiled_maker
def run_controller(readings, desired, columns, control, every, out):
    """A controller on readings, with no machine behind it.

    Args:
        readings: Of each tick (M, 9n and more).
        desired, columns: Of each tick, see `rollout.RunPlan`.
        control: Kind, law, and what it holds, see `make_controller`.
        every: Ticks of a row.
        out: Takes commands and virtual displacement of each row (N, 6n + m).
    """
    kind, law, held = control
    nc = law.shape[1]
    controller = make_controller(kind, law, held)
    commands, none = np.zeros(nc), np.empty(0)
    for tick in range(len(readings)):
        place_desired(desired[tick], columns, controller.desired)
        advance_controller(controller, readings[tick], none, commands)
        if tick % every == 0:
            row = out[tick // every]
            row[0:nc] = commands
            for j in range(columns.shape[0]):
                row[nc + j] = controller.virtual[0, columns[j]]

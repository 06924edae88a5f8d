"""Blocks of the bench run by what was recorded, row by row."""

import numpy as np

from brace_drake.laws.compiled import compiled_maker
from brace_drake.laws.legs import solve_forward_kinematics
from brace_drake.laws.loop import bench_tick, blocks
from brace_drake.laws.rotation import quaternion_to_rotation_vector


@compiled_maker
def calc_poses(lengths, p_WB, p_RT, rest, poses, jacobians):
    """Ring poses of leg lengths.

    Args:
        lengths: l (N, 6), m.
        p_WB, p_RT: Lower and upper anchors in world and ring (6, 3), m.
        rest: Where the ring rests (3,), m.
        poses: Takes position from rest and rotation vector (N, 6).
        jacobians: Takes the rates of the lengths by the ring's (N, 6, 6).
    """
    p_WR = rest.copy()
    q_WR = np.zeros(4)
    q_WR[0] = 1.0
    rates, at = np.empty(6), np.empty(6)
    for i in range(len(lengths)):
        solve_forward_kinematics(lengths[i], p_WB, p_RT, p_WR, q_WR)
        poses[i, 0:3] = p_WR - rest
        quaternion_to_rotation_vector(q_WR, poses[i, 3:6])
        blocks.calc_ring_kinematics(
            q_WR, p_WR, np.zeros(6), p_WB, p_RT, at, rates, jacobians[i]
        )


@compiled_maker
def run_controller(readings, desired, law, memory, every, out):
    """The controller on readings, with no machine behind it.

    Args:
        readings: Of each tick (M, 12).
        desired: Of each tick.
        law: Parameters of the controller.
        memory: What it remembers; advanced.
        every: Ticks of a row.
        out: Takes commands and virtual displacement of each row (N, 7).
    """
    commands = np.empty(6)
    controller = bench_tick.make_controller(law, memory)
    for tick in range(len(readings)):
        bench_tick.advance_tick(
            readings[tick], desired[tick], controller, commands
        )
        if tick % every == 0:
            out[tick // every, 0:6] = commands
            out[tick // every, 6] = memory[bench_tick.Y_VIRTUAL]

"""Kinematics and forces of the legs of a Stewart-Gough stage.

Leg k runs from anchor B_k on the lower ring to anchor T_k on the moving ring
R. Its length is l_k = |p_BkTk|, its direction n_k = p_BkTk / l_k, and its row
of the Jacobian [n_k', (R T_k x n_k)'], so that leg rates are J [v; w] and the
wrench of leg forces f on the ring at Ro is J' f, force first.
"""

import math

import numpy as np

from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.lanes.functions import every, where
from brace_drake.laws.linear_solve import solve_in_place
from brace_drake.laws.rotation import quaternion_to_matrix, rotate_quaternion

NUM_LEGS = 6
_SMALL_STEP = 2e-6  # m


@compiled_law
def calc_leg_kinematics(p_WR, R_WR, p_WB, p_RT, lengths, J):
    """Writes leg lengths (6,), m, and the leg Jacobian (6, 6).

    Args:
        p_WR: Position of the ring's origin in W (3,), m.
        R_WR: Orientation of the ring (3, 3).
        p_WB: Lower anchors in W (6, 3), m.
        p_RT: Upper anchors in the ring (6, 3), m.
        lengths: Output (6,), m.
        J: Output (6, 6), rows [n_k', (p_RoTk_W x n_k)'].
    """
    for k in range(NUM_LEGS):
        tx, ty, tz = p_RT[k, 0], p_RT[k, 1], p_RT[k, 2]
        rx = R_WR[0, 0] * tx + R_WR[0, 1] * ty + R_WR[0, 2] * tz
        ry = R_WR[1, 0] * tx + R_WR[1, 1] * ty + R_WR[1, 2] * tz
        rz = R_WR[2, 0] * tx + R_WR[2, 1] * ty + R_WR[2, 2] * tz
        dx = p_WR[0] + rx - p_WB[k, 0]
        dy = p_WR[1] + ry - p_WB[k, 1]
        dz = p_WR[2] + rz - p_WB[k, 2]
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        nx, ny, nz = dx / length, dy / length, dz / length
        lengths[k] = length
        J[k, 0] = nx
        J[k, 1] = ny
        J[k, 2] = nz
        J[k, 3] = ry * nz - rz * ny
        J[k, 4] = rz * nx - rx * nz
        J[k, 5] = rx * ny - ry * nx


@compiled_law
def calc_leg_rates(J, w_WR, v_WR, rates):
    """Writes leg rates J [v; w] (6,), m/s."""
    for k in range(NUM_LEGS):
        rates[k] = (
            J[k, 0] * v_WR[0]
            + J[k, 1] * v_WR[1]
            + J[k, 2] * v_WR[2]
            + J[k, 3] * w_WR[0]
            + J[k, 4] * w_WR[1]
            + J[k, 5] * w_WR[2]
        )


@compiled_law
def add_leg_wrench(J, forces, F_R_W):
    """Adds J' f to the spatial force F_R_W (6,), torque first as in Drake."""
    for k in range(NUM_LEGS):
        f = forces[k]
        F_R_W[0] += J[k, 3] * f
        F_R_W[1] += J[k, 4] * f
        F_R_W[2] += J[k, 5] * f
        F_R_W[3] += J[k, 0] * f
        F_R_W[4] += J[k, 1] * f
        F_R_W[5] += J[k, 2] * f


@compiled_law
def search_pose(lengths, p_WB, p_RT, p_WR, q_WR, place):
    """`solve_forward_kinematics` without arrays of its own.

    `place` is to work in: (3, 3), (6, 6), (6,), (6,).
    """
    R_WR, J, at_pose, step = place
    arrived = lengths[0] < 0.0
    for _ in range(20):
        quaternion_to_matrix(q_WR, R_WR)
        calc_leg_kinematics(p_WR, R_WR, p_WB, p_RT, at_pose, J)
        for k in range(6):
            # Of copies side by side those that have arrived stay.
            step[k] = where(arrived, 0.0, lengths[k] - at_pose[k])
        if not solve_in_place(J, step):
            return False
        p_WR[0] += step[0]
        p_WR[1] += step[1]
        p_WR[2] += step[2]
        rotate_quaternion(q_WR, step[3], step[4], step[5])
        largest = abs(step[0])
        for k in range(3):
            largest = max(largest, max(abs(step[k]), 0.2 * abs(step[k + 3])))
        arrived = largest < _SMALL_STEP
        if every(arrived):
            return True
    return False


@compiled_maker
def solve_forward_kinematics(lengths, p_WB, p_RT, p_WR, q_WR):
    """Finds the ring pose that has the given leg lengths, by Newton's method.

    Starts from, and writes into, p_WR (3,), m, and q_WR (4,). Converges
    quadratically; it stops when a step moves no anchor by more than about
    2 um, so that the remaining error, its square over a leg's length, is some
    0.03 nm.

    Returns:
        True when converged within 20 steps.
    """
    place = np.empty((3, 3)), np.empty((6, 6)), np.empty(6), np.empty(6)
    return search_pose(lengths, p_WB, p_RT, p_WR, q_WR, place)

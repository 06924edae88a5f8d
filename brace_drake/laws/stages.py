"""Kinematics and statics of S Stewart-Gough stages one upon another.

Stage i joins ring i - 1 to ring i; below the lowest stage is the clamped ring,
whose anchors are given in W. Each stage is that of `brace_drake.laws.legs`,
with lower anchors that move: leg rates are

    l_i' = J_i V_i + J_Li V_(i-1),

with V = [v; w] of a ring in W, and leg forces f put
J_i' f_i + J_L(i+1)' f_(i+1) on ring i, force first. Row k of J_L is
-[n_k', (p_RLoBk_W x n_k)'].
"""

import numpy as np

from brace_drake.laws import legs
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.linear_solve import solve_in_place
from brace_drake.laws.rotation import (
    quaternion_to_matrix,
    quaternion_to_rotation_vector,
    rotate_quaternion,
)


@compiled_law
def place_lower_anchors(pose, R_WL, p_LB, p_WB):
    """Writes the anchors p_WB (6, 3) of a stage on a ring that moves.

    Args:
        pose: q_WL (4), p_WL (3) of the ring below.
        R_WL: Its orientation (3, 3).
        p_LB: Anchors in that ring (6, 3), m.
        p_WB: Output (6, 3), m.
    """
    for k in range(6):
        for i in range(3):
            p_WB[k, i] = pose[4 + i] + (
                R_WL[i, 0] * p_LB[k, 0]
                + R_WL[i, 1] * p_LB[k, 1]
                + R_WL[i, 2] * p_LB[k, 2]
            )


@compiled_law
def calc_lower_jacobian(pose, p_WB, J, J_L):
    """Writes J_L (6, 6) of a stage from its Jacobian J and p_WL in `pose`."""
    for k in range(6):
        nx, ny, nz = J[k, 0], J[k, 1], J[k, 2]
        rx = p_WB[k, 0] - pose[4]
        ry = p_WB[k, 1] - pose[5]
        rz = p_WB[k, 2] - pose[6]
        J_L[k, 0], J_L[k, 1], J_L[k, 2] = -nx, -ny, -nz
        J_L[k, 3] = rz * ny - ry * nz
        J_L[k, 4] = rx * nz - rz * nx
        J_L[k, 5] = ry * nx - rx * ny


@compiled_law
def calc_kinematics(poses, lower, upper, R, p_WB, lengths, J, J_L):
    """Writes leg lengths and Jacobians of all stages.

    Args:
        poses: q_WR (4), p_WR (3) of each moving ring (S, 7); q of any norm.
        lower: Lower anchors (S, 6, 3), m: of the lowest stage in W, of the
            others in the ring below.
        upper: Upper anchors in the rings above (S, 6, 3), m.
        R: Output (S, 3, 3), orientations of the rings.
        p_WB: Output (S, 6, 3), lower anchors in W, m.
        lengths: Output (6 S,), m.
        J: Output (S, 6, 6), of each stage for the ring above.
        J_L: Output (S, 6, 6), for the ring below; that of the lowest stage
            is left alone, as its lower ring is clamped.
    """
    for i in range(poses.shape[0]):
        quaternion_to_matrix(poses[i, 0:4], R[i])
        if i == 0:
            for k in range(6):
                for c in range(3):
                    p_WB[0, k, c] = lower[0, k, c]
        else:
            place_lower_anchors(poses[i - 1], R[i - 1], lower[i], p_WB[i])
        legs.calc_leg_kinematics(
            poses[i, 4:7],
            R[i],
            p_WB[i],
            upper[i],
            lengths[6 * i : 6 * i + 6],
            J[i],
        )
        if i > 0:
            calc_lower_jacobian(poses[i - 1], p_WB[i], J[i], J_L[i])


@compiled_law
def calc_rates(J, J_L, V, rates):
    """Writes leg rates (6 S,), m/s, from V (S, 6), [w; v] as in Drake."""
    for i in range(J.shape[0]):
        own = rates[6 * i : 6 * i + 6]
        legs.calc_leg_rates(J[i], V[i, 0:3], V[i, 3:6], own)
        if i > 0:
            for k in range(6):
                for c in range(3):
                    own[k] += J_L[i, k, c] * V[i - 1, 3 + c]
                    own[k] += J_L[i, k, 3 + c] * V[i - 1, c]


@compiled_law
def add_wrenches(J, J_L, f, F):
    """Adds what leg forces f (6 S,) do to rings to F (S, 6), torque first."""
    for i in range(J.shape[0]):
        own = f[6 * i : 6 * i + 6]
        legs.add_leg_wrench(J[i], own, F[i])
        if i > 0:
            legs.add_leg_wrench(J_L[i], own, F[i - 1])


@compiled_law
def solve_leg_forces(J, J_L, W, scratch, f):
    """Writes the leg forces f (6 S,), N, that put W on the rings.

    J' f = W from the top stage down: J_i' f_i = W_i - J_L(i+1)' f_(i+1).

    Args:
        J, J_L: As `calc_kinematics` writes them.
        W: Force, then torque about Ro, in W, on each ring (6 S,).
        scratch: Place to work in (6, 6).
        f: Output (6 S,).

    Returns:
        False where a stage is singular.
    """
    regular = True
    top = J.shape[0] - 1
    for i in range(top, -1, -1):
        own = f[6 * i : 6 * i + 6]
        for r in range(6):
            own[r] = W[6 * i + r]
            for k in range(6):
                scratch[r, k] = J[i, k, r]
                if i < top:
                    own[r] -= J_L[i + 1, k, r] * f[6 * i + 6 + k]
        regular = solve_in_place(scratch, own) and regular
    return regular


@compiled_law
def place_rings(X, rest, poses):
    """Writes poses (S, 7) of the rings at task coordinates X (6 S,).

    Args:
        X: Of each ring p_WR - rest (3), m, and rotation vector (3), rad.
        rest: Positions at rest (S, 3), m.
        poses: Output (S, 7), q_WR and p_WR.
    """
    for i in range(poses.shape[0]):
        poses[i, 0] = 1.0
        poses[i, 1:4] = 0.0
        x = X[6 * i : 6 * i + 6]
        rotate_quaternion(poses[i, 0:4], x[3], x[4], x[5])
        for c in range(3):
            poses[i, 4 + c] = rest[i, c] + x[c]


@compiled_law
def calc_task_coordinates(poses, rest, X):
    """Writes the task coordinates X (6 S,) of poses, undoing `place_rings`."""
    for i in range(poses.shape[0]):
        for c in range(3):
            X[6 * i + c] = poses[i, 4 + c] - rest[i, c]
        quaternion_to_rotation_vector(poses[i, 0:4], X[6 * i + 3 : 6 * i + 6])


@compiled_law
def turn_task_rates(X, columns, scale):
    """Turns rates of task coordinates into twists [v; w], in place.

    w = E(r) r' with E the left Jacobian of SO(3) at the rotation vector r.

    Args:
        X: Task coordinates (6 S,).
        columns: Rates X' (6 S, m), overwritten by twists, m of them.
        scale: Place to work in (3, 3).
    """
    for i in range(X.shape[0] // 6):
        calc_left_jacobian(X[6 * i + 3 : 6 * i + 6], scale)
        for j in range(columns.shape[1]):
            x = columns[6 * i + 3, j]
            y = columns[6 * i + 4, j]
            z = columns[6 * i + 5, j]
            for c in range(3):
                columns[6 * i + 3 + c, j] = (
                    scale[c, 0] * x + scale[c, 1] * y + scale[c, 2] * z
                )


@compiled_law
def calc_left_jacobian(r, E):
    """Writes the left Jacobian of SO(3) at r (3,), rad: w = E r' in W.

    E = I + (1 - cos a) / a^2 [r] + (a - sin a) / a^3 [r]^2, a = |r|.
    """
    a2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    if a2 < 1e-6:
        # Both series to the order of a^2.
        b, c = 0.5 - a2 / 24.0, 1.0 / 6.0 - a2 / 120.0
    else:
        a = np.sqrt(a2)
        b, c = (1.0 - np.cos(a)) / a2, (a - np.sin(a)) / (a2 * a)
    for i in range(3):
        for j in range(3):
            E[i, j] = c * r[i] * r[j]
        E[i, i] += 1.0 - c * a2
    E[0, 1] -= b * r[2]
    E[1, 0] += b * r[2]
    E[0, 2] += b * r[1]
    E[2, 0] -= b * r[1]
    E[1, 2] -= b * r[0]
    E[2, 1] += b * r[0]

"""Contact of the pads with the torso: the paper's spatial contact force.

Two pads at y = +-pad_offset on the ring R meet the torso T. With s = +1 for
the pad at +y (index 0) and -1 for the other (index 1), t_y the torso's
y-axis and p the vector from To to the pad's centre, the compression is
d = preload + pad_offset - s p.t_y, its rate d' = -s v_rel.t_y, and the normal
force N = max(0, k d + c d') where d > 0, else 0. N presses the torso along
-s t_y. Tangentially mu N tanh(|v_t| / v_s) opposes the sliding of the pad.
"""

import math

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.elementary import tanh


@compiled_law
def calc_compression(s, offset, preload, p_WR, R_WR, V_WR, p_WT, R_WT, V_WT, o):
    """Writes the geometry of one pad's contact.

    Args:
        s: +1 or -1, the pad's side.
        offset, preload: m.
        p_WR, R_WR, V_WR: Pose and spatial velocity [w; v] of the ring.
        p_WT, R_WT, V_WT: The same of the torso.
        o: Output (14,): d, d', p_ToP_W (3), p_RoP_W (3), the velocity of the
            pad relative to the torso (3), t_y in W (3).
    """
    rx = s * offset * R_WR[0, 1]
    ry = s * offset * R_WR[1, 1]
    rz = s * offset * R_WR[2, 1]
    px = p_WR[0] + rx - p_WT[0]
    py = p_WR[1] + ry - p_WT[1]
    pz = p_WR[2] + rz - p_WT[2]
    vx = V_WR[3] + V_WR[1] * rz - V_WR[2] * ry
    vy = V_WR[4] + V_WR[2] * rx - V_WR[0] * rz
    vz = V_WR[5] + V_WR[0] * ry - V_WR[1] * rx
    vx -= V_WT[3] + V_WT[1] * pz - V_WT[2] * py
    vy -= V_WT[4] + V_WT[2] * px - V_WT[0] * pz
    vz -= V_WT[5] + V_WT[0] * py - V_WT[1] * px
    nx, ny, nz = R_WT[0, 1], R_WT[1, 1], R_WT[2, 1]
    o[0] = preload + offset - s * (px * nx + py * ny + pz * nz)
    o[1] = -s * (vx * nx + vy * ny + vz * nz)
    o[2], o[3], o[4] = px, py, pz
    o[5], o[6], o[7] = rx, ry, rz
    o[8], o[9], o[10] = vx, vy, vz
    o[11], o[12], o[13] = nx, ny, nz


@compiled_law
def normal_force(d, d_dot, stiffness, damping):
    """The contact law before it is cut at zero: k d + c d', N."""
    return stiffness * d + damping * d_dot


@compiled_law
def add_pad_forces(s, N, friction, v_s, o, F_R_W, F_T_W, f_T_W):
    """Adds the forces of one pad with normal force N to both bodies.

    Args:
        s: +1 or -1.
        N: Normal force, N, not negative.
        friction, v_s: Coefficient and regularisation speed, m/s.
        o: The geometry as `calc_compression` writes it.
        F_R_W, F_T_W: Spatial forces (6,), torque first, added to.
        f_T_W: Force of the ring on the torso (3,), added to.
    """
    nx, ny, nz = o[11], o[12], o[13]
    along = o[8] * nx + o[9] * ny + o[10] * nz
    tx = o[8] - along * nx
    ty = o[9] - along * ny
    tz = o[10] - along * nz
    # Slower than this tanh(x) is x.
    speed = max(math.sqrt(tx * tx + ty * ty + tz * tz), 1e-15)
    drag = friction * N * tanh(speed / v_s) / speed
    fx = -s * N * nx + drag * tx
    fy = -s * N * ny + drag * ty
    fz = -s * N * nz + drag * tz
    f_T_W[0] += fx
    f_T_W[1] += fy
    f_T_W[2] += fz
    px, py, pz = o[2], o[3], o[4]
    F_T_W[0] += py * fz - pz * fy
    F_T_W[1] += pz * fx - px * fz
    F_T_W[2] += px * fy - py * fx
    F_T_W[3] += fx
    F_T_W[4] += fy
    F_T_W[5] += fz
    rx, ry, rz = o[5], o[6], o[7]
    F_R_W[0] -= ry * fz - rz * fy
    F_R_W[1] -= rz * fx - rx * fz
    F_R_W[2] -= rx * fy - ry * fx
    F_R_W[3] -= fx
    F_R_W[4] -= fy
    F_R_W[5] -= fz

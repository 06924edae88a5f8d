"""One step of a free rigid body, as Drake's discrete plant takes it."""

import numpy as np

from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.rotation import integrate_quaternion, quaternion_to_matrix


@compiled_law
def step_free_body_at(R, q, p, V, body, F_W, dt):
    """`step_free_body` where the body's rotation matrix R is at hand."""
    mass, inertia = body[0], body[1:4]
    # In the body frame the inertia is diagonal and its inverse is cheap.
    wx = R[0, 0] * V[0] + R[1, 0] * V[1] + R[2, 0] * V[2]
    wy = R[0, 1] * V[0] + R[1, 1] * V[1] + R[2, 1] * V[2]
    wz = R[0, 2] * V[0] + R[1, 2] * V[1] + R[2, 2] * V[2]
    tx = R[0, 0] * F_W[0] + R[1, 0] * F_W[1] + R[2, 0] * F_W[2]
    ty = R[0, 1] * F_W[0] + R[1, 1] * F_W[1] + R[2, 1] * F_W[2]
    tz = R[0, 2] * F_W[0] + R[1, 2] * F_W[1] + R[2, 2] * F_W[2]
    hx, hy, hz = inertia[0] * wx, inertia[1] * wy, inertia[2] * wz
    ax = (tx - (wy * hz - wz * hy)) / inertia[0]
    ay = (ty - (wz * hx - wx * hz)) / inertia[1]
    az = (tz - (wx * hy - wy * hx)) / inertia[2]
    V[0] += dt * (R[0, 0] * ax + R[0, 1] * ay + R[0, 2] * az)
    V[1] += dt * (R[1, 0] * ax + R[1, 1] * ay + R[1, 2] * az)
    V[2] += dt * (R[2, 0] * ax + R[2, 1] * ay + R[2, 2] * az)
    for i in range(3):
        V[3 + i] += dt * F_W[3 + i] / mass
        p[i] += dt * V[3 + i]
    integrate_quaternion(q, V[0], V[1], V[2], dt)


@compiled_maker
def step_free_body(q, p, V, body, F_W, dt):
    """Semi-implicit Euler: velocity from the forces now, then the pose.

    m v' = f, I w' = t - w x I w with I = R diag(inertia) R' about the centre
    of mass, which is the body's origin; then p += dt v, q += dt q'(w).

    Args:
        q, p: Quaternion (4,) and position (3,) in W, updated.
        V: Spatial velocity [w; v] in W (6,), updated.
        body: Mass, kg, and principal moments about the origin, kg m^2: at
            least (4,).
        F_W: Spatial force [torque; force] on the origin (6,).
        dt: s.
    """
    R = np.empty((3, 3))
    quaternion_to_matrix(q, R)
    step_free_body_at(R, q, p, V, body, F_W, dt)

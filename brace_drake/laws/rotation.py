"""Rotations: quaternion (w, x, y, z), matrix and rotation vector."""

import math

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.elementary import atan2, cos, sin
from brace_drake.laws.lanes.functions import where


@compiled_law
def quaternion_to_matrix(q, R):
    """Writes the rotation matrix of a quaternion of any norm into R (3, 3)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    s = 2.0 / (w * w + x * x + y * y + z * z)
    R[0, 0] = 1.0 - s * (y * y + z * z)
    R[0, 1] = s * (x * y - w * z)
    R[0, 2] = s * (x * z + w * y)
    R[1, 0] = s * (x * y + w * z)
    R[1, 1] = 1.0 - s * (x * x + z * z)
    R[1, 2] = s * (y * z - w * x)
    R[2, 0] = s * (x * z - w * y)
    R[2, 1] = s * (y * z + w * x)
    R[2, 2] = 1.0 - s * (x * x + y * y)


@compiled_law
def quaternion_to_rotation_vector(q, r):
    """Writes angle times axis into r (3,), rad, the shorter way round."""
    vector = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    sign = where(q[0] >= 0.0, 1.0, -1.0)
    # Below this an angle is its tangent.
    vector = max(vector, 1e-12)
    scale = sign * 2.0 * atan2(vector, abs(q[0])) / vector
    r[0] = scale * q[1]
    r[1] = scale * q[2]
    r[2] = scale * q[3]


@compiled_law
def rotate_quaternion(q, dx, dy, dz):
    """Turns q in place by the rotation vector (dx, dy, dz) given in W."""
    # Below this a sine is its angle.
    angle = max(math.sqrt(dx * dx + dy * dy + dz * dz), 1e-9)
    a = cos(0.5 * angle)
    b = sin(0.5 * angle) / angle
    ex, ey, ez = b * dx, b * dy, b * dz
    w, x, y, z = q[0], q[1], q[2], q[3]
    q[0] = a * w - ex * x - ey * y - ez * z
    q[1] = a * x + ex * w + ey * z - ez * y
    q[2] = a * y + ey * w + ez * x - ex * z
    q[3] = a * z + ez * w + ex * y - ey * x


@compiled_law
def integrate_quaternion(q, wx, wy, wz, dt):
    """Adds dt times the rate of q under the angular velocity w in W.

    The first-order rule of Drake's discrete plants; the norm is left alone.
    """
    h = 0.5 * dt
    w, x, y, z = q[0], q[1], q[2], q[3]
    q[0] = w + h * (-x * wx - y * wy - z * wz)
    q[1] = x + h * (w * wx + z * wy - y * wz)
    q[2] = y + h * (-z * wx + w * wy + x * wz)
    q[3] = z + h * (y * wx - x * wy + w * wz)

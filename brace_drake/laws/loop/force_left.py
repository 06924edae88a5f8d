"""What the legs leave for the torso, to be held against the force readings."""

import numpy as np

from brace_drake.laws import stages
from brace_drake.laws.compiled import compiled_maker


@compiled_maker
def calc_forces_left(poses, V, u, viscous, weights, lower, upper, forces):
    """Writes J' (u - viscous l') - G of each ring, its force part.

    Inertia is left out: at brace speeds m a is below a newton, so this is good
    for telling a sensor that has failed, not for measuring.

    Args:
        poses: q_WR, p_WR of each ring, as estimated (S, 7).
        V: [w; v] of each ring (S, 6).
        u: Leg commands that were held (6 S,), N.
        viscous: Of each leg (6 S,), N s/m.
        weights: Of the rings (S,), N.
        lower, upper: Anchors as the controller knows them, see `laws.stages`.
        forces: Output, of each ring on the torso in W (3 S,), N.
    """
    n = poses.shape[0]
    R, p_WB = np.empty((n, 3, 3)), np.empty((n, 6, 3))
    J, J_L = np.empty((n, 6, 6)), np.empty((n, 6, 6))
    f, F = np.empty(6 * n), np.zeros((n, 6))
    stages.calc_kinematics(poses, lower, upper, R, p_WB, f, J, J_L)
    stages.calc_rates(J, J_L, V, f)
    for k in range(6 * n):
        f[k] = u[k] - viscous[k] * f[k]
    stages.add_wrenches(J, J_L, f, F)
    for i in range(n):
        for c in range(3):
            forces[3 * i + c] = F[i, 3 + c]
        forces[3 * i + 2] -= weights[i]

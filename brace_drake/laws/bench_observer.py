"""What the legs leave for the torso, to be held against the force reading."""

import numpy as np
from numba import njit

from brace_drake.laws import legs
from brace_drake.laws.rotation import quaternion_to_matrix


@njit(cache=True, error_model="numpy")
def calc_force_left(estimate, u, viscous, weight, p_WB, p_RT, force):
    """Writes J' (u - viscous l') - G, its force part; inertia is left out.

    At brace speeds m a is below a newton: good for telling a sensor that has
    failed, not for measuring.

    Args:
        estimate: As `controller.estimate_pose` writes it (19,).
        u: Leg commands that were held (6,), N.
        viscous: Of each leg (6,), N s/m.
        weight: Of the ring, N.
        p_WB, p_RT: Anchors as the controller knows them (6, 3), m.
        force: Output, on the torso in W (3,), N.
    """
    R_WR, J = np.empty((3, 3)), np.empty((6, 6))
    lengths, rates = np.empty(6), np.empty(6)
    quaternion_to_matrix(estimate[15:19], R_WR)
    legs.calc_leg_kinematics(estimate[12:15], R_WR, p_WB, p_RT, lengths, J)
    legs.calc_leg_rates(J, estimate[9:12], estimate[6:9], rates)
    force[0], force[1], force[2] = 0.0, 0.0, -weight
    for k in range(6):
        f = u[k] - viscous[k] * rates[k]
        for i in range(3):
            force[i] += J[k, i] * f

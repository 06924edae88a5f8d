"""The six legs' geometry: lengths, directions, and the pose they hold."""

import math

import numpy as np

from brace_drake.withheld.simulator.compiled import maker, worker
from brace_drake.withheld.simulator.turning import turn


@worker
def leg_geometry(p, R, lower, upper, length, arm, along):
    """Writes lengths (6,), lever arms R T_k and unit vectors (6, 3)."""
    for k in range(6):
        square = 0.0
        for i in range(3):
            arm[k, i] = (
                R[i, 0] * upper[k, 0]
                + R[i, 1] * upper[k, 1]
                + R[i, 2] * upper[k, 2]
            )
            along[k, i] = p[i] + arm[k, i] - lower[k, i]
            square += along[k, i] * along[k, i]
        length[k] = math.sqrt(square)
        for i in range(3):
            along[k, i] /= length[k]


@worker
def screws(arm, along, J):
    """Writes J (6, 6): leg rates of the ring's [v, w]."""
    for k in range(6):
        a, n = arm[k], along[k]
        J[k, 0], J[k, 1], J[k, 2] = n[0], n[1], n[2]
        J[k, 3] = a[1] * n[2] - a[2] * n[1]
        J[k, 4] = a[2] * n[0] - a[0] * n[2]
        J[k, 5] = a[0] * n[1] - a[1] * n[0]


@maker
def find_pose(target, p, R, lower, upper):
    """Moves p and R until the legs have the lengths `target` (6,).

    Newton's method on poses: each correction is a twist, applied by the
    exponential.
    """
    length, arm, along = np.empty(6), np.empty((6, 3)), np.empty((6, 3))
    J = np.empty((6, 6))
    for _ in range(8):
        leg_geometry(p, R, lower, upper, length, arm, along)
        screws(arm, along, J)
        twist = np.linalg.solve(J, target - length)
        for i in range(3):
            p[i] += twist[i]
        turn(twist[3:6], R)
        if np.max(np.abs(twist)) < 1e-11:
            break


@maker
def inverse_mass(R, arm, along, mass, inertia, leg_mass):
    """Inverse of the ring's mass matrix for [v, w] in W, (6, 6).

    A leg that moves its screw and rotor adds `leg_mass` along itself; the
    velocity products of that small mass are left out.
    """
    M = np.zeros((6, 6))
    for i in range(3):
        M[i, i] = mass
        for j in range(3):
            for k in range(3):
                M[3 + i, 3 + j] += R[i, k] * inertia[k] * R[j, k]
    if leg_mass != 0.0:
        J = np.empty((6, 6))
        screws(arm, along, J)
        M += leg_mass * (J.T @ J)
    return np.linalg.inv(M)

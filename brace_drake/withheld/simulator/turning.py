"""Rotation matrices and their exponential coordinates."""

import math

import numpy as np

from brace_drake.withheld.simulator.compiled import maker, worker


@worker
def exponential(a, R):
    """Writes R = exp([a]x) by Rodrigues' formula, series near zero."""
    s2 = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    if s2 < 1e-6:
        p = 1.0 - s2 / 6.0 * (1.0 - s2 / 20.0)
        q = 0.5 - s2 / 24.0 * (1.0 - s2 / 30.0)
    else:
        s = math.sqrt(s2)
        p = math.sin(s) / s
        q = (1.0 - math.cos(s)) / s2
    for i in range(3):
        for j in range(3):
            R[i, j] = q * a[i] * a[j]
        R[i, i] += 1.0 - q * s2
    R[0, 1] -= p * a[2]
    R[1, 0] += p * a[2]
    R[0, 2] += p * a[1]
    R[2, 0] -= p * a[1]
    R[1, 2] -= p * a[0]
    R[2, 1] += p * a[0]


@worker
def logarithm(R, a):
    """Writes the rotation vector of R, for angles well below pi."""
    a[0] = 0.5 * (R[2, 1] - R[1, 2])
    a[1] = 0.5 * (R[0, 2] - R[2, 0])
    a[2] = 0.5 * (R[1, 0] - R[0, 1])
    s = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    c = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    if s > 1e-9:
        factor = math.atan2(s, c) / s
        for i in range(3):
            a[i] *= factor


@worker
def product(A, B, C):
    """Writes C = A B for 3 x 3 matrices; C is neither A nor B."""
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@worker
def apply(A, x, y):
    """Writes y = A x for square matrices of any size."""
    n = len(x)
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += A[i, j] * x[j]
        y[i] = total


@maker
def turn(a, R):
    """Replaces R by exp([a]x) R."""
    E = np.empty((3, 3))
    C = np.empty((3, 3))
    exponential(a, E)
    product(E, R, C)
    R[:, :] = C


@worker
def coordinate_rate(a, w, rate):
    """Writes the rate of exponential coordinates a at angular velocity w.

    First terms of the inverse of the exponential's differential,
    w - a x w / 2 + a x (a x w) / 12, from the world's side (Munthe-Kaas).
    """
    cx = a[1] * w[2] - a[2] * w[1]
    cy = a[2] * w[0] - a[0] * w[2]
    cz = a[0] * w[1] - a[1] * w[0]
    rate[0] = w[0] - 0.5 * cx + (a[1] * cz - a[2] * cy) / 12.0
    rate[1] = w[1] - 0.5 * cy + (a[2] * cx - a[0] * cz) / 12.0
    rate[2] = w[2] - 0.5 * cz + (a[0] * cy - a[1] * cx) / 12.0

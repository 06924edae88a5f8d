"""Friction by an elasto-plastic bristle.

Dupont, Hayward, Armstrong and Altpeter, "Single state elastoplastic friction
models", IEEE Trans. Automatic Control 47(5), 2002: the bristle's deflection z
follows z' = v (1 - a(z, v) z / z_s), friction is s0 z + s1 z'. Below a part
of the deflection of sliding z_s = F_s(v) / s0 nothing slips (a = 0), so it
sticks without creep, unlike LuGre. F_s falls with speed from breakaway to
sliding friction, F_c + F_b exp(-(|v| / v_s)^p) (Stribeck). The bristle's
stiffness is such that it breaks away after the same travel at any friction.
"""

import math

from brace_drake.withheld.simulator.compiled import worker

TRAVEL = 8.0e-6  # m, from rest to sliding
DAMPING_TIME = 1.0e-3  # s, damping over stiffness
STUCK = 0.6  # part of z_s below which nothing slips


@worker
def bristle_stiffness(coulomb, breakaway):
    """Stiffness s0, N/m."""
    return (coulomb + breakaway) / TRAVEL


@worker
def sliding_friction(v, coulomb, breakaway, speed, shape):
    """Friction in steady sliding, N, not negative."""
    if breakaway == 0.0:
        return coulomb
    return coulomb + breakaway * math.exp(-((abs(v) / speed) ** shape))


@worker
def bristle_rate(v, z, sliding, stiffness):
    """Rate of the deflection, m/s."""
    if sliding <= 0.0:
        return 0.0
    z_s = sliding / stiffness
    share = z / z_s if v >= 0.0 else -z / z_s
    if share <= STUCK:
        return v
    if share >= 1.0:
        return v * (1.0 - share)
    a = 0.5 - 0.5 * math.cos(math.pi * (share - STUCK) / (1.0 - STUCK))
    return v * (1.0 - a * share)


@worker
def friction(z, z_rate, stiffness):
    """Force against the motion, N."""
    return stiffness * (z + DAMPING_TIME * z_rate)

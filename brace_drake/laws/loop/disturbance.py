"""Errors that each block of the bench may have, whatever their cause.

Corrections to a block's output that are linear in their coefficients: low
powers of the block's own inputs, their signs, their fading memory, and slow
functions of time. They name no mechanism; a diagnosis uses them to ask which
block's errors a gap looks like. All laws share one vector p: coefficients in
the order of `COUNTS`, then the rate in Hz at which a run was recorded and its
recorded leg rates, sample by sample. Where a sign decides, the recorded rate
does: drives that stick in the recording do not stick in the twin.
"""

import math

from brace_drake.laws.hooks import plug

# Coefficients of each block in p, in this order.
COUNTS = {
    "actuation": 14,
    "mechanism": 5,
    "contact": 8,
    "torso": 13,
    "sensing": 13,
}
_MECHANISM, _CONTACT, _TORSO, _SENSING = 14, 19, 27, 40
NUM_COEFFICIENTS = 53

# Slower than these a sign is not yet one, m/s.
LEG_SPEED, _PAD_SPEED = 1e-3, 2e-3
PRESLIDING = 3e-5
_LAG, _SMOOTHING = 0.003, 0.01
_FIRST_BREATH, _BREATH_STEP, _NUM_BREATHS = 0.12, 0.1, 4


@plug("drive")
def drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    """Leg force from command, its lag, extension and rate.

    The two forms of dry friction follow the recorded rates, one by their sign,
    one with a presliding of `PRESLIDING` (Dahl 1968).

    x: lengths at the start (n), commands through a low pass (n), presliding
    (n), whether set.
    """
    n = l.shape[0]
    samples = (p.shape[0] - NUM_COEFFICIENTS - 1) // n
    row = min(int(t * p[NUM_COEFFICIENTS] + 0.5), samples - 1)
    for k in range(n):
        if x[3 * n] == 0.0:
            x[k], x[n + k] = l[k], u[k]
        x[n + k] += (1.0 - math.exp(-dt / _LAG)) * (u[k] - x[n + k])
        rate = p[NUM_COEFFICIENTS + 1 + row * n + k]
        way = dt * rate / PRESLIDING
        x[2 * n + k] = (x[2 * n + k] + way) / (1.0 + abs(way))
        f[k] += (
            (p[0] + p[7 + k]) * u[k]
            + p[1] * u[k] * abs(u[k])
            + p[2] * math.tanh(u[k])
            + p[3] * (x[n + k] - u[k])
            - p[4] * l_dot[k]
            - p[5] * math.tanh(rate / LEG_SPEED)
            - p[13] * x[2 * n + k]
            - p[6] * (l[k] - x[k])
        )
    x[3 * n] = 1.0


@plug("ring")
def ring(t, dt, p_R, r_R, V, F, p, x):
    """Force on the ring from its place and motion.

    x: velocity one step before (3), acceleration through a low pass (3).
    """
    q = _MECHANISM
    for i in range(3):
        if dt > 0.0:
            a = (V[3 + i] - x[i]) / dt
            x[3 + i] += (1.0 - math.exp(-dt / _SMOOTHING)) * (a - x[3 + i])
        x[i] = V[3 + i]
        F[3 + i] -= p[q] * x[3 + i]
    F[5] -= p[q] * 9.81
    y = p_R[1]
    F[4] -= p[q + 1] * y + p[q + 2] * max(y, 0.0) + p[q + 3] * y * abs(y)
    F[4] -= p[q + 4] * V[4]


@plug("contact")
def contact(t, dt, pad, d, law, N, p, x):
    """Normal force from depth, its rate, and its fading memory.

    x: of both pads, two depths through low passes, then whether set.
    """
    q = _CONTACT
    depth, rate = max(d[0], 0.0), d[1]
    fast, slow = 2 * pad, 2 * pad + 1
    if x[4 + pad] == 0.0:
        x[fast] = x[slow] = depth
        x[4 + pad] = 1.0
    x[fast] += (1.0 - math.exp(-dt / 0.3)) * (depth - x[fast])
    x[slow] += (1.0 - math.exp(-dt / 2.0)) * (depth - x[slow])
    s = math.tanh(rate / _PAD_SPEED)
    N[0] += p[q] * depth**2 + p[q + 1] * depth**3 + p[q + 2] * depth * rate
    N[0] -= p[q + 3] * x[fast] + p[q + 4] * x[slow]
    N[0] += p[q + 5] * depth * s + p[q + 6] * s + p[q + 7]


@plug("torso")
def torso(t, dt, p_T, r_T, V, law, F, p, x):
    """Force on the torso from its place, their fading memory, and time.

    x: displacement through two low passes.
    """
    q = _TORSO
    y = p_T[1]
    x[0] += (1.0 - math.exp(-dt / 0.2)) * (y - x[0])
    x[1] += (1.0 - math.exp(-dt / 2.0)) * (y - x[1])
    F[4] -= p[q] * y * abs(y) + p[q + 1] * y**3
    F[4] -= p[q + 2] * x[0] + p[q + 3] * x[1] + p[q + 4] * t


@plug("compression")
def compression(t, dt, pad, d, p, x):
    """Breath: what the trunk's own motion adds to the depth, by frequency."""
    q = _TORSO + 5
    sign = 1.0 if pad == 0 else -1.0
    for i in range(_NUM_BREATHS):
        w = 2.0 * math.pi * (_FIRST_BREATH + _BREATH_STEP * i)
        c, s = p[q + 2 * i], p[q + 2 * i + 1]
        d[0] += sign * (c * math.cos(w * t) + s * math.sin(w * t))
        d[1] += sign * w * (s * math.cos(w * t) - c * math.sin(w * t))


@plug("sensing")
def sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    """Readings of force and lengths from their true values and time.

    x: force along y through a low pass.
    """
    q = _SENSING
    x[0] += (1.0 - math.exp(-h / 0.02)) * (F[1] - x[0])
    lag = x[0] - F[1]
    F[0] += p[q]
    F[2] += p[q + 1]
    F[1] += p[q + 2] + p[q + 3] * t
    F[1] += p[q + 4] * F[1] + p[q + 5] * lag + p[q + 6] * F[1] * abs(F[1])
    for k in range(6):
        l[k] += p[q + 7 + k]


LAWS = {
    "drive": drive,
    "ring": ring,
    "contact": contact,
    "torso": torso,
    "compression": compression,
    "sensing": sensing,
}
# States of each law: 19 for six legs, two pads' memories.
NUM_STATES = {
    "drive": 19,
    "ring": 6,
    "contact": 6,
    "torso": 2,
    "sensing": 1,
}

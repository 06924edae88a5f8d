"""Which gains a sampled loop carries: its poles, and the limits they set."""

from __future__ import annotations

import math

import numpy as np


def spectral_radius(
    kp: float, kd: float, ki: float, velocity_gain: float, period: float
) -> float:
    """Largest magnitude of a pole of PID on a unit mass, sampled and held.

    x'' = -kp x - kd v - I between ticks; at a tick v is the backward difference
    of x through the estimator's low pass, and I grows by period ki x. Nothing
    but the controller damps the mass. Below 1 the loop is stable; gains beyond
    floating point give inf.
    """
    h, g = period, velocity_gain
    # x, x', x of the last tick, v, I.
    v = np.array([g / h, 0.0, -g / h, 1.0 - g, 0.0])
    integral = np.array([h * ki, 0.0, 0.0, 0.0, 1.0])
    position = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    rate = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    with np.errstate(all="ignore"):
        a = -kp * position - kd * v - integral
        step = [position + h * rate + 0.5 * h * h * a, rate + h * a]
    step = np.array([*step, position, v, integral])
    if not np.isfinite(step).all():
        return math.inf
    if ki == 0.0:
        step = step[:4, :4]
    return float(np.abs(np.linalg.eigvals(step)).max())


def damping_range(
    kp: float, ki: float, velocity_gain: float, period: float
) -> tuple[float, float] | None:
    """Lowest and highest kd, on a unit mass, that leave the loop stable.

    Looked for between 0.01 and 100 over the period; None where there is none.
    """
    tried = np.geomspace(1e-5, 10.0, 400) / period
    good = [
        kd
        for kd in tried
        if spectral_radius(kp, kd, ki, velocity_gain, period) < 1.0
    ]
    return (float(min(good)), float(max(good))) if good else None


def highest_stiffness(
    mass: float, damping_ratio: float, period: float
) -> float:
    """K, N/m, below which the stepped impedance filter is stable.

    4 - 2 h C / M - h^2 K / M > 0 with C = 2 ratio sqrt(M K), solved for K.
    """
    root = 2.0 * (math.sqrt(damping_ratio**2 + 1.0) - damping_ratio)
    return mass * (root / period) ** 2


def filter_margin(M: float, C: float, K: float, period: float) -> float:
    """4 - 2 h C / M - h^2 K / M; above 0 the impedance filter is stable.

    The filter's pole polynomial is z^2 - (2 - h c - h^2 k) z + 1 - h c with
    c = C / M, k = K / M: by Jury's test its value at z = -1 has to be positive.
    """
    return 4.0 - (2.0 * period * C + period**2 * K) / M

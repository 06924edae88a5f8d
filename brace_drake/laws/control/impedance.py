"""A controller's laws of one coordinate: filters, impedance (4), (5)."""

import math

from brace_drake.laws.compiled import compiled_law


@compiled_law
def low_pass_gain_cutoff(cutoff_hz, period):
    """Gain of a discrete first-order low pass, 1 - exp(-2 pi f_c h)."""
    return 1.0 - math.exp(-2.0 * math.pi * cutoff_hz * period)


@compiled_law
def low_pass_gain_tau(tau, period):
    """Gain of a discrete first-order low pass, 1 - exp(-h / tau)."""
    return 1.0 - math.exp(-period / tau)


@compiled_law
def update_velocity_estimate(X, X_previous, V, gain, period):
    """Backward difference of X (6,) through a low pass, in place.

    V += gain ((X - X_previous) / h - V); X_previous takes the value of X.
    """
    for i in range(6):
        V[i] += gain * ((X[i] - X_previous[i]) / period - V[i])
        X_previous[i] = X[i]


@compiled_law
def filter_force(force, gain, filtered):
    """Low pass of the rings' forces (3n,) into rows with torques (6n,)."""
    for i in range(force.shape[0]):
        k = 6 * (i // 3) + i % 3
        filtered[k] += gain * (force[i] - filtered[k])


@compiled_law
def update_impedance(M_d, C_d, K_d, desired, force, period, virtual):
    """One step of the impedance filter along one axis, equation (5).

    a = (M_d y_d'' + C_d (y_d' - y_v') + K_d (y_d - y_v) - F) / M_d, then
    y_v' += h a, y_v += h y_v'.

    Args:
        M_d, C_d, K_d: Desired mass, damping, stiffness; kg, N s/m, N/m.
        desired: y_d, y_d', y_d'' (3,).
        force: Force of the brace on the torso along the axis, N.
        period: h, s.
        virtual: y_v, y_v', a (3,), updated.
    """
    a = (
        M_d * desired[2]
        + C_d * (desired[1] - virtual[1])
        + K_d * (desired[0] - virtual[0])
        - force
    ) / M_d
    virtual[1] += period * a
    virtual[0] += period * virtual[1]
    virtual[2] = a

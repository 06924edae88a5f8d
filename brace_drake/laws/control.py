"""The controller's laws: filters, impedance (4), (5), inverse dynamics (6)."""

import math

from numba import njit

from brace_drake.laws.linear_solve import solve_in_place


@njit(cache=True, error_model="numpy")
def low_pass_gain_cutoff(cutoff_hz, period):
    """Gain of a discrete first-order low pass, 1 - exp(-2 pi f_c h)."""
    return 1.0 - math.exp(-2.0 * math.pi * cutoff_hz * period)


@njit(cache=True, error_model="numpy")
def low_pass_gain_tau(tau, period):
    """Gain of a discrete first-order low pass, 1 - exp(-h / tau)."""
    return 1.0 - math.exp(-period / tau)


@njit(cache=True, error_model="numpy")
def update_velocity_estimate(X, X_previous, V, gain, period):
    """Backward difference of X (6,) through a low pass, in place.

    V += gain ((X - X_previous) / h - V); X_previous takes the value of X.
    """
    for i in range(6):
        V[i] += gain * ((X[i] - X_previous[i]) / period - V[i])
        X_previous[i] = X[i]


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def calc_task_force(X, V, virtual, force, mass, weight, kp, kd, axis, F):
    """Inverse dynamics in the task space, equation (6), for one ring.

    F = M (X_v'' + K_D (X_v' - X') + K_P (X_v - X)) + G + F_e with
    M = diag(m, m, m, I); only one axis has a virtual pose other than 0.
    Coriolis terms are negligible at brace speeds and left out.

    Args:
        X, V: Estimated pose (position, rotation vector) and its rate (6,).
        virtual: Virtual position, velocity, acceleration on `axis` (3,).
        force: Filtered interaction force on `axis`, N.
        mass: Diagonal of M (6,), kg and kg m^2.
        weight: Ring weight on z, N.
        kp, kd: Gains, 1/s^2 and 1/s.
        axis: Index of the impedance-controlled coordinate.
        F: Output (6,), force first.
    """
    for i in range(6):
        F[i] = mass[i] * (-kd * V[i] - kp * X[i])
    F[axis] += mass[axis] * (virtual[2] + kd * virtual[1] + kp * virtual[0])
    F[axis] += force
    F[2] += weight


@njit(cache=True, error_model="numpy")
def distribute_to_legs(J, J_transposed, F, limit, commands):
    """Writes leg commands f = J^-T F (6,), N, each cut at +-limit.

    Args:
        J: Leg Jacobian at the estimated pose (6, 6).
        J_transposed: Scratch (6, 6).
        F: Task-space force (6,), force first.
        limit: N.
        commands: Output (6,).

    Returns:
        False where J is singular.
    """
    for i in range(6):
        commands[i] = F[i]
        for k in range(6):
            J_transposed[i, k] = J[k, i]
    regular = solve_in_place(J_transposed, commands)
    for k in range(6):
        commands[k] = min(limit, max(-limit, commands[k]))
    return regular

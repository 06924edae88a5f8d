"""Model reference adaptive impedance control (MRAIC).

The paper's reference 17 designs "an adaptive law ... to regulate the impedance
parameters such that the actual impedance model follows the reference impedance
model"; its law, gains and structure are not public. What stands here is a
RECONSTRUCTION: the standard Lyapunov design of model reference adaptive
control with projection and sigma modification (Ioannou and Sun, Robust
Adaptive Control, 1996, chapters 6 and 8).
"""

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.control.regressor import NUM_REGRESSOR, step_regressor
from brace_drake.laws.control.task_impedance import (
    follow_reference,
    step_impedance,
)

# Rows of law: gains, lower, upper limits of M, C, K (9); b'P (2); leak; filter.
NUM_MRAIC_LAW = 13
# Rows of memory: regressor (4), e_m, e_m', adapted M, C, K.
NUM_MRAIC_MEMORY = NUM_REGRESSOR + 5


def lyapunov_gains(M_m, C_m, K_m, Q_e, Q_v):
    """b'P of the reference error model, where A'P + PA = -diag(Q_e, Q_v).

    A = [[0, 1], [-K_m/M_m, -C_m/M_m]], b = [0, 1/M_m]. Solved by hand: the
    three equations of the symmetric P decouple.

    Returns:
        p_12 / M_m and p_22 / M_m.
    """
    p_12 = 0.5 * Q_e * M_m / K_m
    p_22 = 0.5 * (Q_v + 2.0 * p_12) * M_m / C_m
    return p_12 / M_m, p_22 / M_m


@compiled_law
def adapt_parameter(theta, start, lower, upper, gain, leak, phi, s, period):
    """One step of an adapted parameter, kept between its limits.

    theta' = gain phi s - leak (theta - start), with s = b'P z.
    """
    theta += period * (gain * phi * s - leak * (theta - start))
    return min(upper, max(lower, theta))


@compiled_law
def adapt_impedance(i, phi, s, period, reference, law, theta):
    """Steps M, C, K of coordinate i.

    Args:
        i: Coordinate.
        phi: e'', e', e.
        s: b'P z, with z = [eps, eps'], eps = e - e_m.
        period: s.
        reference: M_m, C_m, K_m (3, 6n).
        law: See NUM_MRAIC_LAW.
        theta: M, C, K (3, 6n), column i is updated.
    """
    for j in range(3):
        theta[j, i] = adapt_parameter(
            theta[j, i], reference[j, i], law[3 + j, i], law[6 + j, i],
            law[j, i], law[11, i], phi[j], s, period,
        )  # fmt: skip


@compiled_law
def step_reference(M_m, C_m, K_m, force, period, model):
    """One step of M_m e_m'' + C_m e_m' + K_m e_m = F; model is e_m, e_m'."""
    a = (force - C_m * model[1] - K_m * model[0]) / M_m
    model[1] += period * a
    model[0] += period * model[1]


@compiled_law
def advance_mraic(
    desired,
    state,
    force,
    period,
    selected,
    reference,
    law,
    memory,
    virtual,
    impedance,
):
    """MRAIC: equation (5) with an impedance that is adapted to a reference.

    Reference: M_m e_m'' + C_m e_m' + K_m e_m = F. The ring shows
    phi'(theta + delta) = F, with phi = [e'', e', e], e = X_d - X, theta the
    impedance in (5) and delta what the inner loop adds to it, unknown and
    constant. With eps = e - e_m, z = [eps, eps'] and A'P + PA = -Q:

        theta' = Gamma phi (b'P z) - leak (theta - theta_m), kept within limits.

    Without the leak V = z'Pz + d'Gamma^-1 d, d = theta + delta - theta_m, has
    V' = -z'Qz: z dies away, and theta + delta goes to theta_m when the motion
    is rich. Projection cannot raise V while theta_m - delta is within the
    limits; with the leak V stays bounded (by its size times delta). e and F go
    through one filter first (see `regressor`), slower signals than the
    adaptation would break the argument: adaptation rates stay well below the
    filter's bandwidth. The limits are such that the sampled filter (5) is
    stable wherever theta goes.

    Args:
        desired: (3, 6n).
        state: X, X' (2, 6n).
        force: On the torso (6n,), the same as (5) uses.
        period: s.
        selected: Not 0 for coordinates with an impedance (6n,).
        reference: M_m, C_m, K_m (3, 6n).
        law: See NUM_MRAIC_LAW.
        memory: See NUM_MRAIC_MEMORY, updated.
        virtual, impedance: (3, 6n), updated.
    """
    theta = memory[6:9]
    for i in range(selected.shape[0]):
        if selected[i] == 0.0:
            follow_reference(i, desired, virtual, impedance)
            continue
        e_dd, e_d, e, filtered = step_regressor(
            desired[0, i] - state[0, i],
            force[i],
            law[12, i],
            period,
            memory[0:4, i],
        )
        model = memory[4:6, i]
        s = law[9, i] * (e - model[0]) + law[10, i] * (e_d - model[1])
        phi = e_dd, e_d, e
        adapt_impedance(i, phi, s, period, reference, law, theta)
        step_reference(
            reference[0, i], reference[1, i], reference[2, i],
            filtered, period, model,
        )  # fmt: skip
        step_impedance(
            i, theta[0, i], theta[1, i], theta[2, i],
            desired, force[i], period, virtual, impedance,
        )  # fmt: skip

"""Novel position-based impedance control (NPIC).

In the paper's reference 18 "the actual impedance parameters are estimated using
interaction force-motion measurements and the impedance parameters' errors were
then used to regulate the measured interaction force, which is the primary
input of the PIC"; its estimator, gains and structure are not public. What
stands here is a RECONSTRUCTION: recursive least squares with forgetting
(Astrom and Wittenmark, Adaptive Control, 2nd ed. 1995, section 2.2) and a
correction of the force that is linear in the parameters' errors.
"""

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.control.regressor import NUM_REGRESSOR, step_regressor
from brace_drake.laws.control.task_impedance import (
    follow_reference,
    step_impedance,
)

# Rows of law: filter, forgetting, kappa, covariance limit, excitation (5);
# lower, upper limits of the estimated M, C, K over the desired (6).
NUM_NPIC_LAW = 11
# Rows of memory: regressor (4), estimated M, C, K over the desired (3),
# covariance (6: 00, 11, 22, 01, 02, 12), correction of the force.
NUM_NPIC_MEMORY = NUM_REGRESSOR + 10


@compiled_law
def update_estimate(psi, y, forgetting, limit, theta, P):
    """One step of recursive least squares, y = psi' theta.

    g = P psi / (lambda + psi' P psi), theta += g (y - psi' theta),
    P = (P - g psi' P) / lambda. Nothing is forgotten while the trace of P would
    pass its limit: where only one parameter is excited, the others' covariance
    would grow without end.

    Args:
        psi: Regressor (3).
        y: Measured value.
        forgetting: lambda, at most 1.
        limit: Of the trace of P.
        theta: Estimate (3,), updated.
        P: Covariance (6,): 00, 11, 22, 01, 02, 12, updated.
    """
    g_0 = P[0] * psi[0] + P[3] * psi[1] + P[4] * psi[2]
    g_1 = P[3] * psi[0] + P[1] * psi[1] + P[5] * psi[2]
    g_2 = P[4] * psi[0] + P[5] * psi[1] + P[2] * psi[2]
    scale = forgetting + psi[0] * g_0 + psi[1] * g_1 + psi[2] * g_2
    off = psi[0] * theta[0] + psi[1] * theta[1] + psi[2] * theta[2]
    off = (y - off) / scale
    theta[0] += g_0 * off
    theta[1] += g_1 * off
    theta[2] += g_2 * off
    P[0] -= g_0 * g_0 / scale
    P[1] -= g_1 * g_1 / scale
    P[2] -= g_2 * g_2 / scale
    P[3] -= g_0 * g_1 / scale
    P[4] -= g_0 * g_2 / scale
    P[5] -= g_1 * g_2 / scale
    if P[0] + P[1] + P[2] <= limit * forgetting:
        for j in range(6):
            P[j] /= forgetting


@compiled_law
def correct_force(psi, y, law, i, theta, P):
    """Estimates the realised impedance; the force to add in (5), N.

    Args:
        psi: M_d e'', C_d e', K_d e, N.
        y: Force, through the same filter, N.
        law: See NUM_NPIC_LAW.
        i: Coordinate.
        theta, P: As in `update_estimate`, parameters over the desired ones.
    """
    if abs(psi[0]) + abs(psi[1]) + abs(psi[2]) > law[4, i]:
        update_estimate(psi, y, law[1, i], law[3, i], theta, P)
    correction = 0.0
    for j in range(3):
        ratio = min(law[8 + j, i], max(law[5 + j, i], theta[j]))
        correction += psi[j] * (ratio - 1.0)
    return law[2, i] * correction


@compiled_law
def advance_npic(
    desired,
    state,
    force,
    period,
    selected,
    wanted,
    law,
    memory,
    virtual,
    impedance,
):
    """NPIC: the force in (5) is corrected by the realised impedance's error.

    F = phi' theta is fitted with phi = [e'', e', e], e = X_d - X, and

        F_c = F + kappa phi' (theta_hat - theta_d)

    takes the place of F in (5). Where the estimate fits, phi' theta_hat = F and
    F_c = (1 + kappa) F - kappa phi' theta_d: with a perfect inner loop e = F /
    K_d at rest for any kappa; with an imperfect one a kappa above 0 pulls the
    realised impedance to the desired one.

    The correction closes a loop kappa G(s) H(s) around the inner loop G and the
    regressor's filter H, |H| <= 1. An inner loop without a peak has |G| <= 1
    too, so it is stable for kappa < 1 (small gain); the estimate is held within
    limits, so that the correction is bounded by a multiple of the motion.

    Args:
        desired: (3, 6n).
        state: X, X' (2, 6n).
        force: On the torso (6n,), the same as (5) uses without correction.
        period: s.
        selected: Not 0 for coordinates with an impedance (6n,).
        wanted: M_d, C_d, K_d (3, 6n).
        law: See NUM_NPIC_LAW.
        memory: See NUM_NPIC_MEMORY, updated.
        virtual, impedance: (3, 6n), updated.
    """
    for i in range(selected.shape[0]):
        if selected[i] == 0.0:
            follow_reference(i, desired, virtual, impedance)
            continue
        M_d, C_d, K_d = wanted[0, i], wanted[1, i], wanted[2, i]
        e_dd, e_d, e, filtered = step_regressor(
            desired[0, i] - state[0, i],
            force[i],
            law[0, i],
            period,
            memory[0:4, i],
        )
        psi = M_d * e_dd, C_d * e_d, K_d * e
        memory[13, i] = correct_force(
            psi, filtered, law, i, memory[4:7, i], memory[7:13, i]
        )
        step_impedance(
            i, M_d, C_d, K_d, desired, force[i] + memory[13, i],
            period, virtual, impedance,
        )  # fmt: skip

"""Variable position-based impedance control (VPIC), and the limit it needs.

Stability: Kronander and Billard, Stability Considerations for Variable
Impedance Control, IEEE T-RO 32(5), 2016. For M e'' + D(t) e' + K(t) e = 0 with
an alpha > 0 such that

    alpha M - D(t) <= 0   and   K'(t) + alpha D'(t) - 2 alpha K(t) < 0

V = M (e' + alpha e)^2 / 2 + (K + alpha D - alpha^2 M) e^2 / 2 never grows.
"""

import math

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.control.task_impedance import (
    follow_reference,
    step_impedance,
)
from brace_drake.laws.lanes.functions import every, lead, where

# Rows of law: lower, upper limit of K; alpha; damping ratio; gain, slide,
# forgetting of the rule.
NUM_VPIC_LAW = 7
# Rows of memory: stiffness in use, stiffness that the rule asks for.
NUM_VPIC_MEMORY = 2


@compiled_law
def stored_energy(M, K, ratio, alpha, e, e_d):
    """V, J, of the error with stiffness K and damping 2 ratio sqrt(M K)."""
    D = 2.0 * ratio * math.sqrt(M * K)
    sliding = e_d + alpha * e
    beta = K + alpha * D - alpha * alpha * M
    return 0.5 * (M * sliding * sliding + beta * e * e)


@compiled_law
def highest_next_stiffness(M, K, ratio, alpha, period):
    """The largest stiffness of the next tick with which V cannot grow.

    The condition above for the filter as it is stepped, without approximation:
    with x = [e, e'] and x+ = A(K) x the next V+ is at most V for every x where
    P(K) - A' P(K+) A >= 0. Its stiffness enters P(K+) in one entry alone, beta
    of (1, 1), so that this is beta+ <= 1 / (a' S^-1 a) with a' the first row of
    A and S = P(K) - A' P_0 A, P_0 = P with beta 0. As the period goes to 0 it
    becomes K' < 2 alpha K / (1 + alpha ratio sqrt(M / K)), which the condition
    above says for D = 2 ratio sqrt(M K).

    Args:
        M, K: kg, N/m.
        ratio: Damping ratio.
        alpha: 1/s.
        period: s.

    Returns:
        N/m; less than 0 where no stiffness will do.
    """
    k, c = K / M, 2.0 * ratio * math.sqrt(K / M)
    a_0, a_1 = 1.0 - period * period * k, period * (1.0 - period * c)
    u_0 = alpha * a_0 - period * k
    u_1 = (1.0 + alpha * period) * (1.0 - period * c)
    s_00, s_01, s_11 = (
        k + alpha * c - u_0 * u_0,
        alpha - u_0 * u_1,
        1 - u_1 * u_1,
    )
    determinant = s_00 * s_11 - s_01 * s_01
    below = a_0 * a_0 * s_11 - 2.0 * a_0 * a_1 * s_01 + a_1 * a_1 * s_00
    beta = determinant / below
    # beta = k + 2 alpha ratio sqrt(k) - alpha^2, solved for k.
    root = math.sqrt(alpha * alpha * (ratio * ratio + 1.0) + beta)
    root -= alpha * ratio
    some_will = (s_11 > 0.0) & (determinant > 0.0) & (root > 0.0)
    return where(some_will, M * root * root, -1.0)


@compiled_law
def limit_stiffness(request, M, K, ratio, alpha, period, lower, upper):
    """The stiffness nearest to the request that limits and V allow."""
    wanted = min(upper, max(lower, request))
    lowers = wanted <= K
    if every(lowers):
        return wanted
    highest = highest_next_stiffness(M, K, ratio, alpha, period)
    return where(lowers, wanted, max(K, min(wanted, highest)))


@compiled_law
def ask_stiffness(K, rest, gain, slide, forgetting, e, e_d, period):
    """Stiffness of the rule: it grows with the error and is forgotten.

    K' = gain (e' + slide e) e - forgetting (K - K_rest): stiffer while the
    error is large or grows, softer again when it is not needed. Human-like
    adaptation of impedance (Yang, Ganesh, Haddadin, Parusel, Albu-Schaeffer,
    Burdet, IEEE T-RO 27(5), 2011), in continuous time around K_rest.
    """
    growth = gain * (e_d + slide * e) * e
    return K + period * (growth - forgetting * (K - rest))


@compiled_law
def advance_vpic(
    desired,
    state,
    force,
    stiffness,
    period,
    selected,
    wanted,
    law,
    memory,
    virtual,
    impedance,
):
    """VPIC: equation (5) with a stiffness that varies, within what is stable.

    The stiffness comes from outside (a policy: RLPIC) or, where none is given,
    from the rule of `ask_stiffness`; it is held within its limits and raised no
    faster than `highest_next_stiffness` allows. Lowering is free. Damping
    follows as D = 2 ratio sqrt(M_d K).

    With F = 0 and a reference at rest V never grows, whatever is asked; with a
    bounded F the error stays bounded (V' <= F (e' + alpha e)). The impedance is
    passive from F to e' + alpha e, not from F to e'.

    Args:
        desired: (3, 6n).
        state: X, X' (2, 6n).
        force: On the torso (6n,).
        stiffness: Asked for from outside (6n,), N/m, or (0,): by the rule.
        period: s.
        selected: Not 0 for coordinates with an impedance (6n,).
        wanted: M_d, C_d, K_d (3, 6n); K_d is where the rule rests.
        law: See NUM_VPIC_LAW.
        memory: See NUM_VPIC_MEMORY, updated.
        virtual, impedance: (3, 6n), updated.

    Returns:
        False where a stiffness asked for is not a number.
    """
    by_rule = stiffness.shape[0] == 0
    for i in range(selected.shape[0]):
        if lead(selected[i]) == 0.0:
            follow_reference(i, desired, virtual, impedance)
            continue
        M, ratio = wanted[0, i], law[3, i]
        if by_rule:
            asked = ask_stiffness(
                memory[1, i], wanted[2, i], law[4, i], law[5, i], law[6, i],
                desired[0, i] - state[0, i], desired[1, i] - state[1, i],
                period,
            )  # fmt: skip
            asked = min(law[1, i], max(law[0, i], asked))
        else:
            asked = stiffness[i]
        if not every(abs(asked) < math.inf):
            return False
        memory[1, i] = asked
        K = limit_stiffness(
            asked, M, memory[0, i], ratio, law[2, i], period,
            law[0, i], law[1, i],
        )  # fmt: skip
        memory[0, i] = K
        step_impedance(
            i, M, 2.0 * ratio * math.sqrt(M * K), K,
            desired, force[i], period, virtual, impedance,
        )  # fmt: skip
    return True

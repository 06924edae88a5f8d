"""PID control of the rings' pose or of the force, the usual baseline.

"Typical motion control and force control strategies, for example, PID", is what
robotic braces before the paper's used (section 1 there, references 8 to 11).
"""

from brace_drake.laws.compiled import compiled_law

# Rows of law: kp, ki, kd, limit of the integral (4); force-controlled or not,
# desired force, kp and ki of the force (4).
NUM_PID_LAW = 8
# Rows of memory: integral part, N or N m.
NUM_PID_MEMORY = 1


@compiled_law
def integrate(integral, growth, limit, saturated):
    """An integral part that does not wind up.

    It is cut at +-limit, and while a leg is at its force limit it may shrink
    but not grow (conditional integration; Astrom and Hagglund, Advanced PID
    Control, 2006, section 3.5).
    """
    if saturated and growth * integral > 0.0:
        return integral
    return min(limit, max(-limit, integral + growth))


@compiled_law
def is_saturated(command, limit):
    """Whether a leg is at its limit."""
    for k in range(command.shape[0]):
        if abs(command[k]) >= limit[k]:
            return True
    return False


@compiled_law
def advance_pid(
    desired, state, force, period, saturated, law, gravity, memory, F
):
    """Task forces of a PID controller on each coordinate.

    Position: F = kp e + I + kd e' + G with e = X_d - X and I' = ki e.
    Force, where selected: F = f_d + kp_f (f_d - F_e) + I - kd X' + G with
    I' = ki_f (f_d - F_e) and f_d the force wanted on the torso.

    On a mass m with friction c the position loop is stable for
    ki < (kd + c) kp / m (Routh); sampled, for gains that the scenario's check
    lets pass. A PD part on its own is passive; the integral is not, and a torso
    in contact lowers its margin. The force loop on a torso of stiffness k is
    stable for ki_f < (1 + kp_f) (kd + c) / m as long as kp_f >= 0.

    Args:
        desired: (3, 6n).
        state: X, X' (2, 6n).
        force: On the torso (6n,), N and N m.
        period: s.
        saturated: Whether a leg was at its limit in the last tick.
        law: See NUM_PID_LAW.
        gravity: G (6n,).
        memory: See NUM_PID_MEMORY, updated.
        F: Output (6n,).
    """
    for i in range(F.shape[0]):
        if law[4, i] == 0.0:
            e = desired[0, i] - state[0, i]
            proportional = law[0, i] * e
            damping = law[2, i] * (desired[1, i] - state[1, i])
            growth = period * law[1, i] * e
        else:
            off = law[5, i] - force[i]
            proportional = law[5, i] + law[6, i] * off
            damping = -law[2, i] * state[1, i]
            growth = period * law[7, i] * off
        memory[0, i] = integrate(memory[0, i], growth, law[3, i], saturated)
        F[i] = proportional + memory[0, i] + damping + gravity[i]

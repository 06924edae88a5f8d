"""The tissue under one pad, with what it may do beyond a spring and damper.

Nominal: N = k d + c d' where d > 0 and N > 0. On top: a cubic spring; Maxwell
arms, f' = k_a d' - f / tau, here two of them, for tissue has no single time
constant (the second a tenth as stiff and five times as fast); a Bouc-Wen loop
(Wen 1976, exponent 1), H z with z' = (d' - |d'| z / 2 - d' |z| / 2) / w; the
damper of Hunt and Crossley 1975, k d (1 + a d'), instead of c d'; adhesion
that holds on to a leaving pad.
"""

from numba import njit

SECOND_ARM = 0.1
SECOND_TIME = 0.2
# Places in a pad's memory: two arms' forces, N, and the loop's z.
NUM_MEMORY = 3


@njit(cache=True, error_model="numpy")
def start_memory(d, flaws, memory):
    """Writes a pad's memory at first touch: arms not yet relaxed."""
    d = max(0.0, d)
    memory[0] = (1.0 - SECOND_ARM) * flaws.arm * d
    memory[1] = SECOND_ARM * flaws.arm * d
    memory[2] = 0.0


@njit(cache=True, error_model="numpy")
def press(d, d_rate, subject, flaws, memory, memory_rate):
    """Normal force on the torso, N; writes the rates of the memory (3,)."""
    memory_rate[:] = 0.0
    arms = memory[0] + memory[1]
    touching = d > 0.0
    if flaws.arm > 0.0:
        pull = d_rate if touching else 0.0
        slow, fast = flaws.arm_time, flaws.arm_time * SECOND_TIME
        memory_rate[0] = (1.0 - SECOND_ARM) * flaws.arm * pull
        memory_rate[0] -= memory[0] / slow
        memory_rate[1] = SECOND_ARM * flaws.arm * pull - memory[1] / fast
    if flaws.loop > 0.0:
        z = memory[2]
        memory_rate[2] = d_rate - 0.5 * abs(d_rate) * z - 0.5 * d_rate * abs(z)
        memory_rate[2] /= flaws.loop_width
        if not touching:
            memory_rate[2] = -z / 0.05
    if not touching:
        if flaws.stick > 0.0 and d > -flaws.stick_reach:
            x = -d / flaws.stick_reach
            return -4.0 * flaws.stick * x * (1.0 - x)
        return 0.0
    force = subject.stiffness * d + flaws.cubic * d * d * d
    if flaws.crossley >= 0.0:
        force += subject.stiffness * d * flaws.crossley * d_rate
    else:
        force += subject.damping * d_rate
    force += arms + flaws.loop * memory[2]
    return max(force, 0.0)


@njit(cache=True, error_model="numpy")
def rest_compression(pad, subject, flaws):
    """Compression with ring and torso at rest; negative where a gap is."""
    if flaws.gap[pad] >= 0.0:
        return -flaws.gap[pad]
    return subject.preload

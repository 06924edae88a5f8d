"""The tissue under one pad, with what it may do beyond a spring and damper.

Nominal: N = k d + c d' where d > 0 and N > 0. On top: a cubic spring; Maxwell
arms, f' = k_a d' - f / tau, here two of them, for tissue has no single time
constant (the second a tenth as stiff and five times as fast); a Bouc-Wen loop
(Wen 1976, exponent 1), H z with z' = (d' - |d'| z / 2 - d' |z| / 2) / w; the
damper of Hunt and Crossley 1975, k d (1 + a d'), instead of c d'.
"""

from brace_drake.withheld.simulator.compiled import worker

SECOND_ARM = 0.1
SECOND_TIME = 0.2
FORGET_TIME = 0.05  # s, in which a loop is lost once the pad is off
# Places in a pad's memory: two arms' forces, N, and the loop's z.
NUM_MEMORY = 3


@worker
def start_memory(d, flaws, memory):
    """Writes a pad's memory at first touch: arms not yet relaxed."""
    d = max(0.0, d)
    memory[0] = (1.0 - SECOND_ARM) * flaws.arm * d
    memory[1] = SECOND_ARM * flaws.arm * d
    memory[2] = 0.0


@worker
def press(d, d_rate, subject, flaws, memory, memory_rate, first):
    """Normal force on the torso, N.

    The pad's memory begins at `first` in `memory`; its rates are written to
    the same places of `memory_rate`.
    """
    for i in range(NUM_MEMORY):
        memory_rate[first + i] = 0.0
    arms = memory[first] + memory[first + 1]
    touching = d > 0.0
    if flaws.arm > 0.0:
        pull = flaws.arm * d_rate if touching else 0.0
        slow, fast = memory[first], memory[first + 1]
        rate = (1.0 - SECOND_ARM) * pull - slow / flaws.arm_time
        memory_rate[first] = rate
        rate = SECOND_ARM * pull - fast / (SECOND_TIME * flaws.arm_time)
        memory_rate[first + 1] = rate
    if flaws.loop > 0.0:
        z = memory[first + 2]
        rate = d_rate - 0.5 * (abs(d_rate) * z + d_rate * abs(z))
        if not touching:
            rate = -z * flaws.loop_width / FORGET_TIME
        memory_rate[first + 2] = rate / flaws.loop_width
    if not touching:
        return 0.0
    force = subject.stiffness * d + flaws.cubic * d * d * d
    if flaws.crossley >= 0.0:
        force += subject.stiffness * d * flaws.crossley * d_rate
    else:
        force += subject.damping * d_rate
    force += arms + flaws.loop * memory[first + 2]
    return max(force, 0.0)


@worker
def rest_compression(pad, subject, flaws):
    """Compression with ring and torso at rest; negative where a gap is."""
    if flaws.gap[pad] >= 0.0:
        return -flaws.gap[pad]
    return subject.preload

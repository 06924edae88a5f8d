"""A pad on the torso: tissue with what it may do beyond a spring and damper.

Nominal: N = k d + c d' where d > 0 and N > 0. On top: a cubic spring; Maxwell
arms, f' = k_a d' - f / tau, here two of them, for tissue has no single time
constant (the second a tenth as stiff and five times as fast); a Bouc-Wen loop
(Wen 1976, exponent 1), H z with z' = (d' - |d'| z / 2 - d' |z| / 2) / w; the
damper of Hunt and Crossley 1975, k d (1 + a d'), instead of c d'.

A pad slides with friction mu N tanh(v / v_s).
"""

import math

from brace_drake.withheld.simulator.compiled import worker
from brace_drake.withheld.simulator.numbers import (
    PAD_FRICTION,
    PAD_OFFSET,
    PAD_SLIP_SPEED,
    RING_HEIGHTS,
)
from brace_drake.withheld.simulator.state import TISSUE, TORSO

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


@worker
def approach(side, x, R_ring, R_torso, o):
    """Writes how a pad stands to the torso.

    Args:
        side: +1 or -1 along y.
        x: State.
        R_ring, R_torso: Their rotations.
        o: Output (5, 3): the pad from the ring's centre, from the torso's, its
            velocity on the torso, the torso's y-axis; then depth of the pad
            along that axis and its rate.
    """
    for i in range(3):
        o[0, i] = side * PAD_OFFSET * R_ring[i, 1]
        o[1, i] = x[i] + o[0, i] - x[TORSO + i]
        o[3, i] = R_torso[i, 1]
    o[1, 2] -= RING_HEIGHTS[1]
    o[4, 0] = 0.0
    o[4, 1] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        ring = x[6 + i] + x[9 + j] * o[0, k] - x[9 + k] * o[0, j]
        turned = x[TORSO + 9 + j] * o[1, k] - x[TORSO + 9 + k] * o[1, j]
        o[2, i] = ring - x[TORSO + 6 + i] - turned
        o[4, 0] += o[1, i] * o[3, i]
        o[4, 1] += o[2, i] * o[3, i]


@worker
def add_press(side, N, o, on):
    """Adds a pad's normal force N and its friction, see `approach`, to on."""
    square = 0.0
    for i in range(3):
        o[2, i] -= o[4, 1] * o[3, i]
        square += o[2, i] * o[2, i]
    speed = math.sqrt(square)
    grip = PAD_FRICTION * N / PAD_SLIP_SPEED
    if speed > 1e-12:
        grip *= math.tanh(speed / PAD_SLIP_SPEED) / speed * PAD_SLIP_SPEED
    f = o[2]
    for i in range(3):
        f[i] = grip * o[2, i] - side * N * o[3, i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        on[0, i] -= f[i]
        on[1, i] -= o[0, j] * f[k] - o[0, k] * f[j]
        on[2, i] += f[i]
        on[3, i] += o[1, j] * f[k] - o[1, k] * f[j]


@worker
def pad_wrenches(x, breath, bench, run, rates):
    """Adds both pads' forces to those on ring and torso, `run.on`.

    Args:
        x: State.
        breath: Expansion at each pad and its rate (2, 2), m, m/s.
        bench, run: Bench and Run; the force on the torso is the ideal reading.
        rates: State's rates; those of the tissue are written.
    """
    subject, flaws, o = bench.subject, bench.flaws.pads, run.pad
    for pad in range(2):
        side = 1.0 - 2.0 * pad
        approach(side, x, run.rotations[0], run.rotations[1], o)
        d = rest_compression(pad, subject, flaws) + breath[pad, 0]
        d += PAD_OFFSET - side * o[4, 0]
        d_rate = breath[pad, 1] - side * o[4, 1]
        first = TISSUE + 3 * pad
        N = press(d, d_rate, subject, flaws, x, rates, first)
        if N > 0.0:
            add_press(side, N, o, run.on)

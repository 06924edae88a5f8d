"""What the instruments say: drives' encoders and the force sensor.

The force sensor may lag (first order), be off in scale or zero, drift, and
show some of y on its other axes. Encoders sit on the drives' side.
"""

import math

from brace_drake.withheld.simulator.compiled import worker
from brace_drake.withheld.simulator.frame import leg_geometry
from brace_drake.withheld.simulator.legs import is_loose
from brace_drake.withheld.simulator.numbers import FORCE_STEP, LENGTH_STEP, TICK
from brace_drake.withheld.simulator.state import DRIVE


@worker
def read_force(t, force, noise, flaws, lagged, reading):
    """Writes the force sensor's reading (3,), before it is rounded."""
    gain = 1.0
    if flaws.lag > 0.0 and t > 0.0:
        gain = 1.0 - math.exp(-TICK / flaws.lag)
    for i in range(3):
        lagged[i] += gain * (force[i] - lagged[i])
    for i in range(3):
        value = (1.0 + flaws.scale) * lagged[i]
        if i == 1:
            value += flaws.bias + flaws.drift * t
        else:
            value += flaws.crosstalk * lagged[1]
        reading[i] = value + noise[i]


@worker
def to_step(value, step):
    """Rounds to the resolution of an instrument."""
    return step * math.floor(value / step + 0.5)


@worker
def sense(tick, bench, run, out):
    """Writes the readings of a tick, lengths (6) and force (3), to out (9,).

    Also leaves the legs' geometry in `run`, which the mass matrix takes.
    """
    flaws, chance = bench.flaws, bench.chance
    lower, upper = bench.anchors
    leg_geometry(
        run.x[0:3], run.R[0], lower, upper, run.length, run.arm, run.along
    )
    t, noise = tick * TICK, chance.force[tick]
    read_force(t, run.on[2], noise, flaws.sensors, run.lagged, out[6:9])
    for k in range(6):
        length = run.length[k]
        if is_loose(flaws.legs):
            length = run.x[DRIVE + k]
        out[k] = length + flaws.sensors.lengths[k] + chance.lengths[tick, k]
    if bench.rounding:
        for k in range(9):
            out[k] = to_step(out[k], LENGTH_STEP if k < 6 else FORCE_STEP)

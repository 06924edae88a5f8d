"""A whole run of one axis that follows a commanded speed or position.

It is the only engine of this device; closed forms in the tests are its
reference.
"""

import math

from numba import boolean, int64, njit

from brace_drake.laws.compiled import MAKER
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    matrix,
    stack_type,
    vector,
    vectors,
)

# What the law's vector holds: gain of the command, damping, gain of position,
# a constant acceleration, gain of the command's rate; the rate of an integral
# of what the controller asks for, and its own gain of the command's rate; and
# the damping that is no part of that.
COMMAND, DAMPING, POSITION, BIAS, RATE, INTEGRAL, INTEGRATED_RATE = range(7)
VISCOUS, NUMBERS = 7, 8
# Places that the rollout needs.
WORK = 7


@njit(
    int64(
        int64,
        int64,
        boolean,
        vector,
        vector,
        matrix,
        vector,
        stack_type("drive"),
        stack_type("sensing"),
        vectors,
        vectors,
        vectors,
        boolean[:, ::1],
        vector,
        vector,
        matrix,
    ),
    nogil=True,
    **MAKER,
)
def rollout_response(
    steps_per_sample,
    num_commands,
    is_held,
    time,
    command,
    inputs,
    law,
    drive,
    sensing,
    parameters,
    drive_memory,
    sensing_memory,
    active,
    state,
    work,
    log,
):
    """Follows a command and writes position and speed.

    y'' = c r + e r' - k y - (d + b) y' + i + a_0 + effects,
    i' = n (c r + g r' - k y - d y'); of a speed r with a lag T c = d = 1 / T,
    k = 0, of a position c = k = w^2, d = 2 z w, above 0, and of the position
    of a motor e = d as well. The integral i begins as after a long time at
    the speed of the start.
    Half a step of the position, a whole one of the speed, half a step of the
    position (Strang).

    Args:
        steps_per_sample: Plant steps between two samples.
        num_commands: Effects, the first ones, that act on c r + a_0, before the
            position is fed back.
        is_held: Whether the command is held between samples, its rate that of
            the last step; else it goes on a straight line from each to the
            next.
        time: Sample times from 0 (N,), s.
        command: r (N,).
        inputs: Extra inputs (N, J).
        law: c, d, k, a_0, e, n, g, b (8,).
        drive, sensing: Laws of the effects; what is read is the position.
        parameters, drive_memory, sensing_memory: Their parameters and states.
        active: Whether an effect sits at drive and sensing (2, MAX_EFFECTS).
        state: y and y' at the start (2,), updated.
        work: Work space (WORK + J,).
        log: Output (N, 2): y, y'.

    Returns:
        -1 when all went well, else the sample at which the run broke down.
    """
    y, v = state[0:1], state[1:2]
    f, u, more = work[0:1], work[1:2], inputs.shape[1]
    read, no_force = work[2:3], work[3:6]
    known = work[6 : 7 + more]
    damping = law[DAMPING] + law[VISCOUS]
    known[0] = damping
    samples, integral = time.shape[0], 0.0
    if law[INTEGRAL] > 0.0:
        integral = law[VISCOUS] * v[0] - law[BIAS]
    for i in range(samples):
        following = min(i + 1, samples - 1)
        h = time[following] - time[following - 1]
        read[0] = y[0]
        for e in range(MAX_EFFECTS):
            if active[1, e]:
                sensing[e](
                    time[i], h, u, read, no_force,
                    parameters[e], sensing_memory[e],
                )  # fmt: skip
        log[i, 0] = read[0]
        log[i, 1] = v[0]
        if following == i:
            break
        dt = h / steps_per_sample
        slope = 0.0 if is_held else (command[following] - command[i]) / h
        rate = (command[i] - command[max(0, i - 1)]) / h if is_held else slope
        for j in range(more):
            known[1 + j] = inputs[i, j]
        for sub in range(steps_per_sample):
            y[0] += 0.5 * dt * v[0]
            r = command[i] + slope * (sub + 0.5) * dt
            # What the controller integrates, but for the speed in it.
            error = law[COMMAND] * r - law[POSITION] * y[0]
            error += law[INTEGRATED_RATE] * rate
            before, n = v[0], law[INTEGRAL] * dt
            middle = integral + 0.5 * n * (error - law[DAMPING] * before)
            u[0] = law[COMMAND] * r + law[BIAS] + law[RATE] * rate + middle
            f[0] = u[0] - damping * v[0]
            for e in range(MAX_EFFECTS):
                if e == num_commands:
                    f[0] -= law[POSITION] * y[0]
                if active[0, e]:
                    drive[e](
                        time[i] + sub * dt, dt, u, y, v, known, f,
                        parameters[e], drive_memory[e],
                    )  # fmt: skip
            if num_commands == MAX_EFFECTS:
                f[0] -= law[POSITION] * y[0]
            # Of a constant command this is exact, whatever the lag.
            damped = max(damping * dt, 1e-12)
            v[0] += dt * f[0] * (-math.expm1(-damped) / damped)
            mean = 0.5 * (before + v[0])
            integral += n * (error - law[DAMPING] * mean)
            y[0] += 0.5 * dt * v[0]
        if not abs(v[0]) < 1e9:
            return i
    return -1

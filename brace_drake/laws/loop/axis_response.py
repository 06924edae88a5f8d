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
# and a constant acceleration.
COMMAND, DAMPING, POSITION, BIAS = range(4)
# Places that the rollout needs.
WORK = 4


@njit(
    int64(
        int64,
        vector,
        vector,
        matrix,
        vector,
        stack_type("drive"),
        vectors,
        vectors,
        boolean[::1],
        vector,
        vector,
        matrix,
    ),
    nogil=True,
    **MAKER,
)
def rollout_response(
    steps_per_sample,
    time,
    command,
    inputs,
    law,
    drive,
    parameters,
    drive_memory,
    active,
    state,
    work,
    log,
):
    """Follows a command and writes position and speed.

    y'' = c r - k y - d y' + a_0 + effects; of a speed r with a lag T
    c = d = 1 / T, k = 0, of a position c = k = w^2, d = 2 z w, above 0. The
    command is held between samples.

    Args:
        steps_per_sample: Plant steps between two samples.
        time: Sample times from 0 (N,), s.
        command: r (N,).
        inputs: Extra inputs (N, J).
        law: c, d, k, a_0 (4,).
        drive: Laws of the effects; what is commanded is c r - k y + a_0.
        parameters, drive_memory: Their parameters and states.
        active: Whether an effect sits at each place (MAX_EFFECTS,).
        state: y and y' at the start (2,), updated.
        work: Work space (WORK + J,).
        log: Output (N, 2): y, y'.

    Returns:
        -1 when all went well, else the sample at which the run broke down.
    """
    y, v = state[0:1], state[1:2]
    f, u, more = work[0:1], work[1:2], inputs.shape[1]
    known = work[2 : 3 + more]
    known[0] = law[DAMPING]
    samples = time.shape[0]
    for i in range(samples):
        log[i, 0] = y[0]
        log[i, 1] = v[0]
        if i + 1 == samples:
            break
        h = time[i + 1] - time[i]
        dt = h / steps_per_sample
        for j in range(more):
            known[1 + j] = inputs[i, j]
        for sub in range(steps_per_sample):
            u[0] = law[COMMAND] * command[i] - law[POSITION] * y[0] + law[BIAS]
            f[0] = u[0] - law[DAMPING] * v[0]
            for e in range(MAX_EFFECTS):
                if active[e]:
                    drive[e](
                        time[i] + sub * dt, dt, u, y, v, known, f,
                        parameters[e], drive_memory[e],
                    )  # fmt: skip
            # Of a constant command this is exact, whatever the lag.
            damped = law[DAMPING] * dt
            v[0] += dt * f[0] * (-math.expm1(-damped) / damped)
            y[0] += dt * v[0]
        if not abs(v[0]) < 1e9:
            return i
    return -1

"""A whole run of the leg bench in one compiled call, and its laws.

It is the only engine of this device; closed forms in the tests are its
reference.
"""

import numpy as np
from numba import float64, int64, njit

from brace_drake.laws.compiled import MAKER, compiled_maker
from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    matrix,
    stack_type,
    vector,
    vectors,
)

# Columns of the log.
NUM_LOGGED = 2


@compiled_maker
def calc_servo_command(reading, asked, control, previous, u):
    """One tick of the position control, with its velocity estimate.

    u = kv (kp (y_d - y) - v) + f_a within +-limit, v = (y - y_2) / (2 h): the
    difference of the mean of two successive readings.

    Args:
        reading: y, m.
        asked: y_d, m, force f_a added to the command, N (2 or more,).
        control: kp, kv, limit, period h (4,).
        previous: The last two readings, newer first (2,), m, updated.
        u: Output (1,), N.
    """
    kp, kv, limit, period = control[0], control[1], control[2], control[3]
    v = (reading - previous[1]) / (2.0 * period)
    force = kv * (kp * (asked[0] - reading) - v) + asked[1]
    u[0] = min(max(force, -limit), limit)
    previous[1] = previous[0]
    previous[0] = reading


@compiled_maker
def calc_drive_force(u, viscous, velocity, f):
    """Force of the drive, f = u - b y', all (1,), before any effect."""
    f[0] = u[0] - viscous[0] * velocity[0]


@njit(
    int64(
        float64,
        int64,
        int64,
        matrix,
        vector,
        vector,
        vector,
        vector,
        vector,
        vector,
        vector,
        stack_type("drive"),
        stack_type("sensing"),
        vectors,
        vectors,
        vectors,
        matrix,
    ),
    nogil=True,
    **MAKER,
)
def rollout_leg(
    dt,
    steps_per_tick,
    ticks_per_sample,
    asked,
    mass,
    viscous,
    offset,
    control,
    noise,
    state,
    previous,
    drive,
    sensing,
    parameters,
    drive_memory,
    sensing_memory,
    log,
):
    """Simulates m y'' = f - offset + load and writes the run's log.

    Semi-implicit Euler: y' += dt y'', y += dt y'.

    Args:
        dt: Plant step, s.
        steps_per_tick, ticks_per_sample: Plant steps in a control period,
            control periods in a logged sample.
        asked: At each tick: reference, m, force added to the command, N,
            further load on the drive, N (ticks, 3).
        mass, viscous, offset: (1,); kg, N s/m, N.
        control: kp, kv, limit, period (4,).
        noise: Of the reading at each tick (ticks,), m, or (0,).
        state: Initial y, y' (2,), updated.
        previous: Readings before the first tick, newer first (2,), updated.
        drive, sensing: Laws of the effects.
        parameters, drive_memory, sensing_memory: Their parameters and states.
        log: Output (samples, 2): command, N; reading, m.

    Returns:
        -1 when all went well, else the tick at which the run broke down.
    """
    position, velocity = state[0:1], state[1:2]
    work = np.zeros(6)
    # A leg alone reads no force.
    u, f, length, no_force = work[0:1], work[1:2], work[2:3], work[3:6]
    period = dt * steps_per_tick
    for tick in range(asked.shape[0]):
        length[0] = position[0]
        for e in range(MAX_EFFECTS):
            sensing[e](
                tick * period, period, u, length, no_force,
                parameters[e], sensing_memory[e],
            )  # fmt: skip
        reading = length[0]
        if noise.shape[0] > 0:
            reading += noise[tick]
        calc_servo_command(reading, asked[tick], control, previous, u)
        if tick % ticks_per_sample == 0:
            log[tick // ticks_per_sample, 0] = u[0]
            log[tick // ticks_per_sample, 1] = reading
        for sub in range(steps_per_tick):
            calc_drive_force(u, viscous, velocity, f)
            for e in range(MAX_EFFECTS):
                drive[e](
                    tick * period + sub * dt, dt, u, position, velocity,
                    viscous, f, parameters[e], drive_memory[e],
                )  # fmt: skip
            force = f[0] - offset[0] + asked[tick, 2]
            velocity[0] += dt * (force / mass[0])
            position[0] += dt * velocity[0]
        if not abs(velocity[0]) < 100.0:
            return tick
    return -1

"""One run: the controller ticks at 1 kHz, the machine moves in between.

Motion is integrated by the classical Runge-Kutta method on poses
(Munthe-Kaas, "High order Runge-Kutta methods on manifolds", Applied Numerical
Mathematics 29, 1999): turns within a step are exponential coordinates.
"""

import math

import numpy as np
from numba import njit

from brace_drake.withheld.stand_in import control as controller
from brace_drake.withheld.stand_in.drives import (
    delivered,
    joint_stretch,
)
from brace_drake.withheld.stand_in.frame import (
    inverse_mass,
    leg_geometry,
    screws,
)
from brace_drake.withheld.stand_in.instruments import sense
from brace_drake.withheld.stand_in.motion import (
    DRIVE,
    NUM_STATE,
    TISSUE,
    TORSO,
    calc_rates,
    make_scratch,
)
from brace_drake.withheld.stand_in.numbers import (
    GRAVITY,
    LOG_EVERY,
    RING_HEIGHTS,
    RING_INERTIA,
    RING_MASS,
    TICK,
)
from brace_drake.withheld.stand_in.pads import rest_compression, start_memory
from brace_drake.withheld.stand_in.turning import turn

# Columns of a log: commands (6), lengths (6), force (3), torso (3), virtual y.
NUM_COLUMNS = 19
MUSCLE_TIME = 0.03  # s, from a reflex's nerve signal to force


@njit(cache=True, error_model="numpy")
def advance(
    t, h, x, R, u, W, breath, push, contact, subject, flaws, g, scratch, k
):
    """Moves the state and the rotations (2, 3, 3) on by one step h, s.

    `breath` (3, 2, 2) holds the expansion at the step's start, middle and end,
    k (5, NUM_STATE) is room for the rates of four stages and a state.
    """
    on, y = scratch.on, k[4]
    y[:] = x
    for stage in range(4):
        if stage > 0:
            part = h if stage == 3 else 0.5 * h
            for i in range(NUM_STATE):
                y[i] = x[i] + part * k[stage - 1, i]
        at = (stage + 1) // 2
        when = t + 0.5 * h * at
        calc_rates(
            when,
            y,
            R,
            u,
            W,
            breath[at],
            push,
            contact,
            subject,
            flaws,
            g,
            scratch,
            on,
            k[stage],
        )
    for i in range(NUM_STATE):
        x[i] += h / 6.0 * (k[0, i] + 2.0 * (k[1, i] + k[2, i]) + k[3, i])
    for i in range(2):
        b = 12 * i + 3
        turn(x[b : b + 3], R[i])
        x[b : b + 3] = 0.0


@njit(cache=True, error_model="numpy")
def begin(x, R, subject, flaws, expansion, contact, g):
    """Writes the state at rest: ring and torso at their rest poses."""
    x[:] = 0.0
    x[2] = RING_HEIGHTS[1]
    for i in range(2):
        R[i] = np.eye(3)
    length, arm, along = np.empty(6), np.empty((6, 3)), np.empty((6, 3))
    J = np.empty((6, 6))
    leg_geometry(x[0:3], R[0], g[0], g[1], length, arm, along)
    screws(arm, along, J)
    weight = np.zeros(6)
    weight[2] = (RING_MASS + flaws.ring.mass) * GRAVITY
    carried = np.linalg.solve(np.ascontiguousarray(J.T), weight)
    for k in range(6):
        x[DRIVE + k] = length[k] + joint_stretch(carried[k], flaws.legs)
    if contact:
        for pad in range(2):
            first = TISSUE + 3 * pad
            d = rest_compression(pad, subject, flaws.pads) + expansion[pad]
            start_memory(d, flaws.pads, x[first : first + 3])


@njit(cache=True, error_model="numpy")
def expansion_at(expansion, tick, share, out):
    """Writes the expansion within a tick and its rate (2, 2)."""
    for pad in range(2):
        a, b = expansion[tick, pad], expansion[tick + 1, pad]
        out[pad, 0] = a + share * (b - a)
        out[pad, 1] = (b - a) / TICK


@njit(cache=True, error_model="numpy")
def reflex(tick, past, flaws, push):
    """Muscles' force after this tick, N, from the torso's past (n, 2)."""
    if flaws.reflex_stiffness == 0.0 and flaws.reflex_damping == 0.0:
        return 0.0
    then = tick - round(flaws.reflex_delay / TICK)
    wanted = 0.0
    if then >= 0:
        wanted = -flaws.reflex_stiffness * past[then, 0]
        wanted -= flaws.reflex_damping * past[then, 1]
    return push + (1.0 - math.exp(-TICK / MUSCLE_TIME)) * (wanted - push)


@njit(cache=True, error_model="numpy")
def drive(tick, sent, lost, flaws, held, u):
    """Writes what the drives deliver (6,) of the commands sent so far."""
    for k in range(6):
        if lost[tick, k] == 0 and tick >= flaws.delay:
            held[k] = sent[tick - flaws.delay, k]
        u[k] = delivered(held[k], flaws.gain[k], flaws)


@njit(cache=True, error_model="numpy")
def move(
    tick,
    steps,
    x,
    R,
    u,
    W,
    expansion,
    push,
    contact,
    subject,
    flaws,
    g,
    scratch,
    stages,
):
    """Moves the machine on by one tick in `steps` steps."""
    breath = np.empty((3, 2, 2))
    h = TICK / steps
    for step in range(steps):
        for at in range(3):
            expansion_at(expansion, tick, (step + 0.5 * at) / steps, breath[at])
        advance(
            tick * TICK + step * h,
            h,
            x,
            R,
            u,
            W,
            breath,
            push,
            contact,
            subject,
            flaws,
            g,
            scratch,
            stages,
        )


@njit(cache=True, error_model="numpy")
def record(
    wanted, contact, subject, flaws, g, nominal, rounding, steps, random
):
    """Runs the bench.

    Args:
        wanted: Reference y, y', y'' at 1 kHz (n, 3).
        contact: Whether the torso is there.
        subject, flaws: Subject, Flaws.
        g: Anchors as they are (2, 6, 3), m.
        nominal: Anchors as the controller knows them.
        rounding: Whether readings are rounded to their resolution.
        steps: Of the integration in a tick.
        random: Noise of lengths (n, 6) and force (n, 3), chest expansion of
            both pads (n + 1, 2), lost commands (n, 6).

    Returns:
        (n / LOG_EVERY, NUM_COLUMNS), without the marker's noise.
    """
    length_noise, force_noise, expansion, lost = random
    noise = (length_noise, force_noise)
    n = len(wanted)
    log = np.empty(((n + LOG_EVERY - 1) // LOG_EVERY, NUM_COLUMNS))
    x, R = np.empty(NUM_STATE), np.empty((2, 3, 3))
    begin(x, R, subject, flaws, expansion[0], contact, g)
    p_found, R_found = x[0:3].copy(), R[0].copy()
    memory = np.zeros(controller.NUM_MEMORY)
    sent, past = np.zeros((n, 6)), np.zeros((n, 2))
    held, u, lagged = np.zeros(6), np.zeros(6), np.zeros(3)
    scratch, stages = make_scratch(), np.zeros((5, NUM_STATE))
    reading, breath = np.empty(9), np.zeros((2, 2))
    W, push = np.eye(6), 0.0
    mass = RING_MASS + flaws.ring.mass
    for tick in range(n):
        t, row = tick * TICK, log[tick // LOG_EVERY]
        # The force at this instant, of the rates that are not used.
        expansion_at(expansion, tick, 0.0, breath)
        calc_rates(
            t,
            x,
            R,
            u,
            W,
            breath,
            push,
            contact,
            subject,
            flaws,
            g,
            scratch,
            scratch.on,
            stages[0],
        )
        sense(
            tick,
            x,
            R,
            g,
            scratch.on,
            flaws,
            noise,
            rounding,
            scratch,
            lagged,
            reading,
        )
        W[:, :] = inverse_mass(
            R[0],
            scratch.arm,
            scratch.along,
            mass,
            RING_INERTIA,
            flaws.ring.leg_mass,
        )
        controller.control(
            tick == 0,
            reading[0:6],
            reading[7],
            wanted[tick],
            p_found,
            R_found,
            nominal,
            memory,
            sent[tick],
        )
        past[tick, 0], past[tick, 1] = x[TORSO + 1], x[TORSO + 7]
        push = reflex(tick, past, flaws.torso, push)
        drive(tick, sent, lost, flaws.legs, held, u)
        if tick % LOG_EVERY == 0:
            row[0:6] = sent[tick]
            row[6:15] = reading
            row[15:18] = x[TORSO : TORSO + 3]
            row[18] = memory[controller.VIRTUAL]
        move(
            tick,
            steps,
            x,
            R,
            u,
            W,
            expansion,
            push,
            contact,
            subject,
            flaws,
            g,
            scratch,
            stages,
        )
    return log

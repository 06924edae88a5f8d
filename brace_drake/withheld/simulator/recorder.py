"""One run: the controller ticks at 1 kHz, the machine moves in between.

Motion is integrated by the classical Runge-Kutta method on poses
(Munthe-Kaas, "High order Runge-Kutta methods on manifolds", Applied Numerical
Mathematics 29, 1999): turns within a step are exponential coordinates.
"""

import math

import numpy as np

from brace_drake.withheld.simulator import control as controller
from brace_drake.withheld.simulator.compiled import maker, worker
from brace_drake.withheld.simulator.drives import delivered
from brace_drake.withheld.simulator.frame import inverse_mass
from brace_drake.withheld.simulator.instruments import sense
from brace_drake.withheld.simulator.motion import NUM_STATE, TORSO, calc_rates
from brace_drake.withheld.simulator.numbers import (
    LOG_EVERY,
    RING_INERTIA,
    RING_MASS,
    TICK,
)
from brace_drake.withheld.simulator.turning import turn

# Columns of a log: commands (6), lengths (6), force (3), torso (3), virtual y.
NUM_COLUMNS = 19
MUSCLE_TIME = 0.03  # s, from a reflex's nerve signal to force


@worker
def advance(
    t, h, x, R, u, W, breath, push, contact, subject, flaws, g, scratch, k
):
    """Moves the state and the rotations (2, 3, 3) on by one step h, s.

    `breath` (3, 2, 2) holds the expansion at the step's start, middle and end,
    k (5, NUM_STATE) is room for the rates of four stages and a state.
    """
    on, y = scratch.on, k[4]
    for i in range(NUM_STATE):
        y[i] = x[i]
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


@worker
def expansion_at(expansion, tick, share, out):
    """Writes the expansion within a tick and its rate (2, 2)."""
    for pad in range(2):
        a, b = expansion[tick, pad], expansion[tick + 1, pad]
        out[pad, 0] = a + share * (b - a)
        out[pad, 1] = (b - a) / TICK


@worker
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


@worker
def drive(tick, sent, lost, flaws, held, u):
    """Writes what the drives deliver (6,) of the commands sent so far."""
    for k in range(6):
        if lost[tick, k] == 0 and tick >= flaws.delay:
            held[k] = sent[tick - flaws.delay, k]
        u[k] = delivered(held[k], flaws.gain[k], flaws)


@maker
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


@maker
def advance_run(
    first,
    last,
    run,
    wanted,
    contact,
    subject,
    flaws,
    g,
    nominal,
    rounding,
    steps,
    random,
    log,
):
    """Performs ticks from `first` to before `last`, the machine in between.

    Args:
        first, last: Ticks.
        run: From `begin_run`, updated.
        wanted: Reference y, y', y'' at 1 kHz (n, 3).
        contact: Whether the torso is there.
        subject, flaws: Subject, Flaws.
        g: Anchors as they are (2, 6, 3), m.
        nominal: Anchors as the controller knows them.
        rounding: Whether readings are rounded to their resolution.
        steps: Of the integration in a tick.
        random: Noise of lengths (n, 6) and force (n, 3), chest expansion of
            both pads (n + 1, 2), lost commands (n, 6).
        log: Output (n / LOG_EVERY, NUM_COLUMNS), without the marker's noise.
    """
    length_noise, force_noise, expansion, lost = random
    noise = (length_noise, force_noise)
    reading, breath = np.empty(9), np.zeros((2, 2))
    mass = RING_MASS + flaws.ring.mass
    x, R, W, scratch = run.x, run.R, run.W, run.scratch
    for tick in range(first, last):
        t, row = tick * TICK, log[tick // LOG_EVERY]
        # The force at this instant, of the rates that are not used.
        expansion_at(expansion, tick, 0.0, breath)
        calc_rates(
            t,
            x,
            R,
            run.u,
            W,
            breath,
            run.push[0],
            contact,
            subject,
            flaws,
            g,
            scratch,
            scratch.on,
            run.stages[0],
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
            run.lagged,
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
            run.p_found,
            run.R_found,
            nominal,
            run.memory,
            run.sent[tick],
        )
        run.past[tick, 0] = x[TORSO + 1]
        run.past[tick, 1] = x[TORSO + 7]
        run.push[0] = reflex(tick, run.past, flaws.torso, run.push[0])
        drive(tick, run.sent, lost, flaws.legs, run.held, run.u)
        if tick % LOG_EVERY == 0:
            row[0:6] = run.sent[tick]
            row[6:15] = reading
            row[15:18] = x[TORSO : TORSO + 3]
            row[18] = run.memory[controller.VIRTUAL]
        move(
            tick,
            steps,
            x,
            R,
            run.u,
            W,
            expansion,
            run.push[0],
            contact,
            subject,
            flaws,
            g,
            scratch,
            run.stages,
        )

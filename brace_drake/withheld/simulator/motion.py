"""Motion of ring and torso: at rest, its rates, and a step of integration.

A step is one of the classical Runge-Kutta method on poses (Munthe-Kaas, "High
order Runge-Kutta methods on manifolds", Applied Numerical Mathematics 29,
1999): turns within a step are exponential coordinates.
"""

import math

import numpy as np

from brace_drake.withheld.simulator.compiled import maker, worker
from brace_drake.withheld.simulator.frame import leg_geometry, screws
from brace_drake.withheld.simulator.legs import joint_stretch, leg_wrench
from brace_drake.withheld.simulator.numbers import (
    GRAVITY,
    POSTURE,
    POSTURE_DAMPING,
    RING_HEIGHTS,
    RING_INERTIA,
    RING_MASS,
    TORSO_INERTIA,
)
from brace_drake.withheld.simulator.pads import (
    pad_wrenches,
    rest_compression,
    start_memory,
)
from brace_drake.withheld.simulator.state import (
    DRIVE,
    NUM_STATE,
    TISSUE,
    TORSO,
)
from brace_drake.withheld.simulator.turning import (
    apply,
    coordinate_rate,
    exponential,
    logarithm,
    product,
    turn,
)


@maker
def begin(bench, run):
    """Writes the state at rest: ring and torso at their rest poses."""
    x, flaws, expansion = run.x, bench.flaws, bench.chance.expansion[0]
    x[2] = RING_HEIGHTS[1]
    lower, upper = bench.anchors
    leg_geometry(x[0:3], run.R[0], lower, upper, run.length, run.arm, run.along)
    J = np.empty((6, 6))
    screws(run.arm, run.along, J)
    weight = np.zeros(6)
    weight[2] = (RING_MASS + flaws.ring.mass) * GRAVITY
    carried = np.linalg.solve(np.ascontiguousarray(J.T), weight)
    for k in range(6):
        x[DRIVE + k] = run.length[k] + joint_stretch(carried[k], flaws.legs)
    if bench.contact:
        for pad in range(2):
            first = TISSUE + 3 * pad
            rest = rest_compression(pad, bench.subject, flaws.pads)
            d = rest + expansion[pad]
            start_memory(d, flaws.pads, x[first : first + 3])
    run.p_found[:] = x[0:3]


@worker
def posture_wrench(t, x, R, bench, run, out):
    """Writes force and torque (6,) of posture and muscles on the torso."""
    subject, flaws, a = bench.subject, bench.flaws.torso, run.a
    logarithm(R, a)
    shift = 0.0
    if flaws.creep != 0.0:
        shift = flaws.creep * (1.0 - math.exp(-t / flaws.creep_time))
    tremor = math.sin(2.0 * math.pi * flaws.tremor_rate * t)
    for i in range(3):
        k, c, rest = POSTURE[i], POSTURE_DAMPING[i], 0.0
        if i == 1:
            k, c, rest = (
                subject.posture_stiffness,
                subject.posture_damping,
                shift,
            )
        out[i] = -k * (x[TORSO + i] - rest) - c * x[TORSO + 6 + i]
        out[i] += flaws.tremor[i] * tremor
        turn_rate = x[TORSO + 9 + i]
        out[3 + i] = -POSTURE[3 + i] * a[i] - POSTURE_DAMPING[3 + i] * turn_rate
    out[1] += run.push[0]


@worker
def surroundings(x, flaws, on):
    """Adds weight on a tilted table, a cable along x, a stop along y."""
    weight = (RING_MASS + flaws.mass) * GRAVITY
    tx, ty = flaws.tilt[0], flaws.tilt[1]
    on[0, 0] += weight * math.sin(tx)
    on[0, 1] += weight * math.sin(ty)
    on[0, 2] -= weight * math.sqrt(1.0 - math.sin(tx) ** 2 - math.sin(ty) ** 2)
    if flaws.cable > 0.0 and x[1] < flaws.cable_start:
        on[0, 0] += flaws.cable * (flaws.cable_start - x[1])
    if flaws.stop > 0.0 and x[1] < flaws.stop_start:
        on[0, 1] += flaws.stop * (flaws.stop_start - x[1])


@worker
def turn_acceleration(R, inertia, w, torque, run, out):
    """Writes Euler's equation for a free body, in W: out (3,)."""
    body_w, body_t, b = run.a, run.b, run.c
    apply(R.T, w, body_w)
    apply(R.T, torque, body_t)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        gyro = (inertia[k] - inertia[j]) * body_w[j] * body_w[k]
        b[i] = (body_t[i] - gyro) / inertia[i]
    apply(R, b, out)


@worker
def ring_acceleration(x, R, run, out):
    """Writes the ring's [v', w'] (6,) by its inverse mass matrix."""
    body_w, spin, load, on = run.a, run.b, run.load, run.on
    apply(R.T, x[9:12], body_w)
    for i in range(3):
        body_w[i] *= RING_INERTIA[i]
    apply(R, body_w, spin)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        load[i] = on[0, i]
        load[3 + i] = on[1, i] - x[9 + j] * spin[k] + x[9 + k] * spin[j]
    apply(run.W, load, out)


@worker
def torso_acceleration(t, x, R, bench, run, out):
    """Writes the torso's [v', w'] (6,)."""
    load, on = run.body_load, run.on
    posture_wrench(t, x, R, bench, run, load)
    for i in range(3):
        out[i] = (load[i] + on[2, i]) / bench.subject.torso_mass
        load[3 + i] += on[3, i]
    spin = x[TORSO + 9 : TORSO + 12]
    turn_acceleration(R, TORSO_INERTIA, spin, load[3:6], run, out[3:6])


@worker
def calc_rates(t, x, breath, bench, run, rates):
    """Writes the state's rates (NUM_STATE,), and forces and torques, `run.on`.

    Args:
        t: s.
        x: State, its turns since the rotations `run.R`.
        breath: Expansion at each pad and its rate (2, 2).
        bench, run: Bench and Run.
        rates: Output.
    """
    R = run.rotations
    run.on[:, :] = 0.0
    for body in range(2):
        b = 12 * body
        turned, spin = x[b + 3 : b + 6], x[b + 9 : b + 12]
        exponential(turned, run.turned)
        product(run.turned, run.R[body], R[body])
        for i in range(3):
            rates[b + i] = x[b + 6 + i]
        coordinate_rate(turned, spin, rates[b + 3 : b + 6])
    if bench.contact:
        pad_wrenches(x, breath, bench, run, rates)
        out = rates[TORSO + 6 : TORSO + 12]
        torso_acceleration(t, x, R[1], bench, run, out)
    leg_wrench(x, R[0], bench, run, rates)
    surroundings(x, bench.flaws.ring, run.on)
    ring_acceleration(x, R[0], run, rates[6:12])


@worker
def advance(t, h, bench, run):
    """Moves state and rotations on by one step h, s; `run.breath` is known."""
    x, k, y = run.x, run.stages, run.stages[4]
    for i in range(NUM_STATE):
        y[i] = x[i]
    for stage in range(4):
        if stage > 0:
            part = h if stage == 3 else 0.5 * h
            for i in range(NUM_STATE):
                y[i] = x[i] + part * k[stage - 1, i]
        at = (stage + 1) // 2
        calc_rates(t + 0.5 * h * at, y, run.breath[at], bench, run, k[stage])
    for i in range(NUM_STATE):
        x[i] += h / 6.0 * (k[0, i] + 2.0 * (k[1, i] + k[2, i]) + k[3, i])
    for i in range(2):
        b = 12 * i + 3
        turn(x[b : b + 3], run.R[i])
        x[b : b + 3] = 0.0

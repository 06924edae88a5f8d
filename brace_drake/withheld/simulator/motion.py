"""Rates of everything that moves: ring, torso, bristles, drives, tissue.

The state holds, for ring and torso alike, position, turn since the tick's
step began (exponential coordinates), velocity and angular velocity, all in W.
"""

import math
from typing import NamedTuple

import numpy as np

from brace_drake.withheld.simulator.compiled import maker, worker
from brace_drake.withheld.simulator.drives import leg_force
from brace_drake.withheld.simulator.frame import leg_geometry
from brace_drake.withheld.simulator.numbers import (
    GRAVITY,
    PAD_FRICTION,
    PAD_OFFSET,
    PAD_SLIP_SPEED,
    POSTURE,
    POSTURE_DAMPING,
    RING_HEIGHTS,
    RING_INERTIA,
    RING_MASS,
    TORSO_INERTIA,
)
from brace_drake.withheld.simulator.pads import press, rest_compression
from brace_drake.withheld.simulator.turning import (
    apply,
    apply_back,
    coordinate_rate,
    exponential,
    logarithm,
    product,
)

RING, TORSO, BRISTLE, DRIVE, TISSUE = 0, 12, 24, 30, 36
NUM_STATE = 42


class Scratch(NamedTuple):
    """Arrays that the hot loop writes into, made once per run."""

    rotations: np.ndarray  # (2, 3, 3)
    step: np.ndarray  # (3, 3)
    length: np.ndarray  # (6,)
    arm: np.ndarray  # (6, 3)
    along: np.ndarray  # (6, 3)
    load: np.ndarray  # (6,)
    body_load: np.ndarray  # (6,)
    a: np.ndarray  # (3,)
    b: np.ndarray  # (3,)
    c: np.ndarray  # (3,)
    on: np.ndarray  # (4, 3)
    pad: np.ndarray  # (5, 3)


@maker
def make_scratch():
    """A new Scratch."""
    return Scratch(
        np.empty((2, 3, 3)),
        np.empty((3, 3)),
        np.empty(6),
        np.empty((6, 3)),
        np.empty((6, 3)),
        np.empty(6),
        np.empty(6),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty((4, 3)),
        np.empty((5, 3)),
    )


@worker
def posture_wrench(t, x, R, subject, flaws, push, a, out):
    """Writes force and torque (6,) of posture and muscles on the torso."""
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
    out[1] += push


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
def pad_wrenches(x, R, breath, subject, flaws, o, on, rates):
    """Adds both pads' forces.

    Args:
        x: State.
        R: Rotations of ring and torso (2, 3, 3).
        breath: Expansion at each pad and its rate (2, 2), m, m/s.
        subject, flaws: Subject and PadFlaws.
        o: Room for `approach`.
        on: Output (4, 3), added to: force and torque on the ring, then on the
            torso. The force on the torso is the ideal reading.
        rates: State's rates; those of the tissue are written.
    """
    for pad in range(2):
        side = 1.0 - 2.0 * pad
        approach(side, x, R[0], R[1], o)
        d = rest_compression(pad, subject, flaws) + breath[pad, 0]
        d += PAD_OFFSET - side * o[4, 0]
        d_rate = breath[pad, 1] - side * o[4, 1]
        first = TISSUE + 3 * pad
        N = press(d, d_rate, subject, flaws, x, rates, first)
        if N > 0.0:
            add_press(side, N, o, on)


@worker
def leg_wrench(x, R, u, lower, upper, flaws, scratch, on, rates):
    """Adds the legs' force and torque on the ring; rates of their memory."""
    length, arm, along = scratch.length, scratch.arm, scratch.along
    leg_geometry(x[0:3], R, lower, upper, length, arm, along)
    for k in range(6):
        n0, n1, n2 = along[k, 0], along[k, 1], along[k, 2]
        m0 = arm[k, 1] * n2 - arm[k, 2] * n1
        m1 = arm[k, 2] * n0 - arm[k, 0] * n2
        m2 = arm[k, 0] * n1 - arm[k, 1] * n0
        rate = n0 * x[6] + n1 * x[7] + n2 * x[8]
        rate += m0 * x[9] + m1 * x[10] + m2 * x[11]
        f, q_rate, z_rate = leg_force(
            u[k], x[DRIVE + k], length[k], rate, x[BRISTLE + k], flaws
        )
        rates[DRIVE + k] = q_rate
        rates[BRISTLE + k] = z_rate
        on[0, 0] += f * n0
        on[0, 1] += f * n1
        on[0, 2] += f * n2
        on[1, 0] += f * m0
        on[1, 1] += f * m1
        on[1, 2] += f * m2


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
def turn_acceleration(R, inertia, w, torque, scratch, out):
    """Writes Euler's equation for a free body, in W: out (3,)."""
    body_w, body_t, b = scratch.a, scratch.b, scratch.c
    apply_back(R, w, body_w)
    apply_back(R, torque, body_t)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        gyro = (inertia[k] - inertia[j]) * body_w[j] * body_w[k]
        b[i] = (body_t[i] - gyro) / inertia[i]
    apply(R, b, out)


@worker
def ring_acceleration(x, R, on, W, scratch, out):
    """Writes the ring's [v', w'] (6,) by its inverse mass matrix W."""
    body_w, spin, load = scratch.a, scratch.b, scratch.load
    apply_back(R, x[9:12], body_w)
    for i in range(3):
        body_w[i] *= RING_INERTIA[i]
    apply(R, body_w, spin)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        load[i] = on[0, i]
        load[3 + i] = on[1, i] - x[9 + j] * spin[k] + x[9 + k] * spin[j]
    apply(W, load, out)


@worker
def torso_acceleration(t, x, R, on, subject, flaws, push, scratch, out):
    """Writes the torso's [v', w'] (6,)."""
    load = scratch.body_load
    posture_wrench(t, x, R, subject, flaws, push, scratch.a, load)
    for i in range(3):
        out[i] = (load[i] + on[2, i]) / subject.torso_mass
        load[3 + i] += on[3, i]
    spin = x[TORSO + 9 : TORSO + 12]
    turn_acceleration(R, TORSO_INERTIA, spin, load[3:6], scratch, out[3:6])


@worker
def calc_rates(
    t, x, R0, u, W, breath, push, contact, subject, flaws, g, scratch, on, o
):
    """Writes the state's rates o (NUM_STATE,).

    Args:
        t: s.
        x: State.
        R0: Rotations of ring and torso where the step began (2, 3, 3).
        u: What the drives deliver (6,), N.
        W: Inverse of the ring's mass matrix (6, 6).
        breath: Expansion at each pad and its rate (2, 2).
        push: Muscles' force on the torso along y, N.
        contact: Whether the torso is there.
        subject, flaws: Subject, Flaws.
        g: Anchors (2, 6, 3) as they are.
        scratch: Scratch.
        on: Output (4, 3): force and torque on ring and of the ring on torso.
    """
    R = scratch.rotations
    on[:, :] = 0.0
    for body in range(2):
        b = 12 * body
        exponential(x[b + 3 : b + 6], scratch.step)
        product(scratch.step, R0[body], R[body])
        for i in range(3):
            o[b + i] = x[b + 6 + i]
        coordinate_rate(x[b + 3 : b + 6], x[b + 9 : b + 12], o[b + 3 : b + 6])
    if contact:
        pad_wrenches(x, R, breath, subject, flaws.pads, scratch.pad, on, o)
        torso_acceleration(
            t,
            x,
            R[1],
            on,
            subject,
            flaws.torso,
            push,
            scratch,
            o[TORSO + 6 : TORSO + 12],
        )
    leg_wrench(x, R[0], u, g[0], g[1], flaws.legs, scratch, on, o)
    surroundings(x, flaws.ring, on)
    ring_acceleration(x, R[0], on, W, scratch, o[6:12])

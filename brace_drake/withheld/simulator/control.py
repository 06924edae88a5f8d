"""The bench's controller: pose-based impedance control at 1 kHz.

Pose of the measured lengths, its rate through a low pass, the force through
another, an impedance along y that yields to the force, and the commands that
hold the ring there by inverse dynamics.
"""

import math

import numpy as np

from brace_drake.withheld.simulator.compiled import maker, worker
from brace_drake.withheld.simulator.frame import find_pose, leg_geometry, screws
from brace_drake.withheld.simulator.numbers import (
    CUTOFF_HZ,
    DESIRED_DAMPING,
    DESIRED_MASS,
    DESIRED_STIFFNESS,
    FORCE_TAU,
    GRAVITY,
    KD,
    KP,
    LEG_LIMIT,
    RING_HEIGHTS,
    RING_INERTIA,
    RING_MASS,
    TICK,
)
from brace_drake.withheld.simulator.turning import logarithm

RATE_GAIN = 1.0 - math.exp(-2.0 * math.pi * CUTOFF_HZ * TICK)
FORCE_GAIN = 1.0 - math.exp(-TICK / FORCE_TAU)
# Places of the memory: pose (6), its rate (6), force, virtual y, its rate,
# desired stiffness and damping along y.
POSE, RATE, FORCE, VIRTUAL, VIRTUAL_RATE = 0, 6, 12, 13, 14
STIFFNESS, DAMPING = 15, 16
NUM_MEMORY = 17


@maker
def make_memory():
    """The memory before the first tick, with the data sheet's impedance."""
    memory = np.zeros(NUM_MEMORY)
    memory[STIFFNESS], memory[DAMPING] = DESIRED_STIFFNESS, DESIRED_DAMPING
    return memory


@worker
def give_way(wanted, reading, memory):
    """One step of the impedance along y; returns its acceleration."""
    memory[FORCE] += FORCE_GAIN * (reading - memory[FORCE])
    spring = memory[STIFFNESS] * (wanted[0] - memory[VIRTUAL])
    damper = memory[DAMPING] * (wanted[1] - memory[VIRTUAL_RATE])
    a = wanted[2] + (damper + spring - memory[FORCE]) / DESIRED_MASS
    memory[VIRTUAL_RATE] += TICK * a
    memory[VIRTUAL] += TICK * memory[VIRTUAL_RATE]
    return a


@maker
def control(first, lengths, reading, wanted, p, R, g, memory, commands):
    """One tick.

    Args:
        first: Whether it is the first, with no pose before it.
        lengths: Measured (6,), m.
        reading: Measured force along y, N.
        wanted: Reference y, y', y'' (3,).
        p, R: The pose found last, updated.
        g: Nominal anchors (2, 6, 3).
        memory: (NUM_MEMORY,), updated.
        commands: Output (6,), N.
    """
    find_pose(lengths, p, R, g[0], g[1])
    pose = np.empty(6)
    pose[0:3] = p
    pose[2] -= RING_HEIGHTS[1]
    logarithm(R, pose[3:6])
    if first:
        memory[POSE : POSE + 6] = pose
    for i in range(6):
        slope = (pose[i] - memory[POSE + i]) / TICK
        memory[RATE + i] += RATE_GAIN * (slope - memory[RATE + i])
        memory[POSE + i] = pose[i]
    a = give_way(wanted, reading, memory)
    wrench = np.empty(6)
    for i in range(6):
        inertia = RING_MASS if i < 3 else RING_INERTIA[i - 3]
        error, rate_error, ahead = -pose[i], -memory[RATE + i], 0.0
        if i == 1:
            error += memory[VIRTUAL]
            rate_error += memory[VIRTUAL_RATE]
            ahead = a
        wrench[i] = inertia * (ahead + KD * rate_error + KP * error)
    wrench[1] += memory[FORCE]
    wrench[2] += RING_MASS * GRAVITY
    length, arm, along = np.empty(6), np.empty((6, 3)), np.empty((6, 3))
    J = np.empty((6, 6))
    leg_geometry(p, R, g[0], g[1], length, arm, along)
    screws(arm, along, J)
    commands[:] = np.linalg.solve(np.ascontiguousarray(J.T), wrench)
    for k in range(6):
        commands[k] = max(-LEG_LIMIT, min(LEG_LIMIT, commands[k]))

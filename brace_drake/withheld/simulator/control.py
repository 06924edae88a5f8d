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


def make_memory() -> np.ndarray:
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
def control(tick, reading, wanted, nominal, run):
    """One tick.

    Args:
        tick: The first, 0, has no pose before it.
        reading: Measured lengths (6), m, and force (3), N.
        wanted: Reference y, y', y'' (3,).
        nominal: Lower and upper anchors as the controller knows them.
        run: Run; its pose and memory are updated, its commands written.
    """
    p, R, memory, commands = (
        run.p_found,
        run.R_found,
        run.memory,
        run.sent[tick],
    )
    lower, upper = nominal
    find_pose(reading[0:6], p, R, lower, upper)
    pose = np.empty(6)
    pose[0:3] = p
    pose[2] -= RING_HEIGHTS[1]
    logarithm(R, pose[3:6])
    if tick == 0:
        memory[POSE : POSE + 6] = pose
    for i in range(6):
        slope = (pose[i] - memory[POSE + i]) / TICK
        memory[RATE + i] += RATE_GAIN * (slope - memory[RATE + i])
        memory[POSE + i] = pose[i]
    a = give_way(wanted, reading[7], memory)
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
    leg_geometry(p, R, lower, upper, length, arm, along)
    screws(arm, along, J)
    commands[:] = np.linalg.solve(np.ascontiguousarray(J.T), wrench)
    for k in range(6):
        commands[k] = max(-LEG_LIMIT, min(LEG_LIMIT, commands[k]))

"""A run before its first tick, and what it carries from tick to tick."""

from typing import NamedTuple

import numpy as np

from brace_drake.withheld.simulator import control as controller
from brace_drake.withheld.simulator.compiled import maker
from brace_drake.withheld.simulator.drives import joint_stretch
from brace_drake.withheld.simulator.frame import leg_geometry, screws
from brace_drake.withheld.simulator.motion import (
    DRIVE,
    NUM_STATE,
    TISSUE,
    Scratch,
    make_scratch,
)
from brace_drake.withheld.simulator.numbers import (
    GRAVITY,
    RING_HEIGHTS,
    RING_MASS,
)
from brace_drake.withheld.simulator.pads import rest_compression, start_memory


class Run(NamedTuple):
    """A run between two ticks: everything that the next one depends on.

    Attributes:
        x: State (NUM_STATE,), m, m/s; ring, drives, tissue, torso.
        R: Rotations of ring and torso (2, 3, 3).
        p_found, R_found: Pose that the controller found last.
        memory: Of the controller, see `control`.
        sent: Commands (n, 6), N.
        past: The torso's y and its rate at each tick (n, 2).
        held, u: Last commands that came through, forces of the drives (6,), N.
        lagged: Of the force sensor (3,), N.
        W: Inverse mass (6, 6).
        push: Of the muscles' reflex (1,), N.
        scratch, stages: Room to work in.
    """

    x: np.ndarray
    R: np.ndarray
    p_found: np.ndarray
    R_found: np.ndarray
    memory: np.ndarray
    sent: np.ndarray
    past: np.ndarray
    held: np.ndarray
    u: np.ndarray
    lagged: np.ndarray
    W: np.ndarray
    push: np.ndarray
    scratch: Scratch
    stages: np.ndarray


@maker
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


@maker
def begin_run(n, contact, subject, flaws, g, expansion):
    """A run of n ticks before the first of them; see `advance_run`."""
    x, R = np.empty(NUM_STATE), np.empty((2, 3, 3))
    begin(x, R, subject, flaws, expansion[0], contact, g)
    return Run(
        x,
        R,
        x[0:3].copy(),
        R[0].copy(),
        controller.make_memory(),
        np.zeros((n, 6)),
        np.zeros((n, 2)),
        np.zeros(6),
        np.zeros(6),
        np.zeros(3),
        np.eye(6),
        np.zeros(1),
        make_scratch(),
        np.zeros((5, NUM_STATE)),
    )

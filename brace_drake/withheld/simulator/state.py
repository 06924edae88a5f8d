"""A bench during a run: what stays, what moves, and room to work in."""

from typing import NamedTuple

import numpy as np

from brace_drake.withheld.simulator.chance import Chance
from brace_drake.withheld.simulator.flaws import Flaws
from brace_drake.withheld.simulator.numbers import Subject

# Places in the state: of ring and torso alike position, turn since the step
# began (exponential coordinates), velocity and angular velocity, all in W;
# of the legs bristles and drives; of both pads three numbers each.
RING, TORSO, BRISTLE, DRIVE, TISSUE = 0, 12, 24, 30, 36
NUM_STATE = 42


class Bench(NamedTuple):
    """What stays as it is during a run.

    Attributes:
        contact: Whether the torso is there.
        subject: Who or what is in the brace.
        flaws: What is wrong.
        anchors: Of the legs as they are: lower in W, upper in the ring (6, 3),
            m.
        nominal: The same as the controller knows them.
        chance: What is random.
        rounding: Whether readings are rounded to their resolution.
        steps: Of the integration in a tick.
    """

    contact: bool
    subject: Subject
    flaws: Flaws
    anchors: tuple[np.ndarray, np.ndarray]
    nominal: tuple[np.ndarray, np.ndarray]
    chance: Chance
    rounding: bool
    steps: int


class Run(NamedTuple):
    """Everything that a tick leaves to the next one, and room to work in."""

    x: np.ndarray  # (NUM_STATE,), m, m/s
    R: np.ndarray  # (2, 3, 3), rotations of ring and torso
    p_found: np.ndarray  # (3,), m, pose that the controller found last
    R_found: np.ndarray  # (3, 3)
    memory: np.ndarray  # of the controller, see `control`
    sent: np.ndarray  # (n, 6), N, commands
    past: np.ndarray  # (n, 2), m, m/s, the torso's y and its rate
    held: np.ndarray  # (6,), N, last commands that came through
    u: np.ndarray  # (6,), N, forces of the drives
    lagged: np.ndarray  # (3,), N, of the force sensor
    W: np.ndarray  # (6, 6), inverse of the ring's mass matrix
    push: np.ndarray  # (1,), N, of the muscles' reflex along y
    on: np.ndarray  # (4, 3), force and torque on ring, of the ring on torso
    stages: np.ndarray  # (5, NUM_STATE), rates of four stages, and a state
    breath: np.ndarray  # (3, 2, 2), expansion at pads, rate; step's 3 times
    rotations: np.ndarray  # (2, 3, 3), of ring and torso within a step
    turned: np.ndarray  # (3, 3), since the step began
    length: np.ndarray  # (6,), m, of the legs, see `frame.leg_geometry`
    arm: np.ndarray  # (6, 3), m
    along: np.ndarray  # (6, 3)
    load: np.ndarray  # (6,), wrench on the ring
    body_load: np.ndarray  # (6,), and on the torso
    a: np.ndarray  # (3,)
    b: np.ndarray  # (3,)
    c: np.ndarray  # (3,)
    pad: np.ndarray  # (5, 3), see `pads.approach`


def make_run(ticks: int, memory: np.ndarray) -> Run:
    """A run of so many ticks, its state not yet at rest."""
    R, empty = np.stack([np.eye(3)] * 2), np.empty
    return Run(
        x=np.zeros(NUM_STATE),
        R=R,
        p_found=np.zeros(3),
        R_found=np.eye(3),
        memory=memory,
        sent=np.zeros((ticks, 6)),
        past=np.zeros((ticks, 2)),
        held=np.zeros(6),
        u=np.zeros(6),
        lagged=np.zeros(3),
        W=np.eye(6),
        push=np.zeros(1),
        on=empty((4, 3)),
        stages=np.zeros((5, NUM_STATE)),
        breath=np.zeros((3, 2, 2)),
        rotations=empty((2, 3, 3)),
        turned=empty((3, 3)),
        length=empty(6),
        arm=empty((6, 3)),
        along=empty((6, 3)),
        load=empty(6),
        body_load=empty(6),
        a=empty(3),
        b=empty(3),
        c=empty(3),
        pad=empty((5, 3)),
    )

"""The bench's tick: PIC along y of a brace of one stage."""

import numpy as np

from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.control import brace_control

# Memory of the pose estimator (20), filtered force (6), X_v, X_v', X_v'' (18),
# impedance in use (18); where y_v is among them.
NUM_MEMORY = 62
Y_VIRTUAL = 27


@compiled_maker
def make_memory(rest):
    """A controller's memory (62,) before its first tick, ring at rest (3,)."""
    memory = np.zeros(NUM_MEMORY)
    memory[0:3], memory[3] = rest, 1.0
    return memory


@compiled_maker
def make_controller(law, memory):
    """What `advance_tick` takes, made once for many ticks.

    Args:
        law: Shared rows of `brace_control`, one after another (102,).
        memory: See NUM_MEMORY; ticks update it.
    """
    rows = law.reshape((-1, 6))
    return (
        np.zeros((3, 6)),
        rows,
        brace_control.take_geometry(rows, 1),
        memory[0:20].reshape((1, 20)),
        memory[20:26],
        memory[26:44].reshape((3, 6)),
        memory[44:62].reshape((3, 6)),
        brace_control.take_work(1),
    )


@compiled_law
def advance_tick(readings, desired, controller, commands):
    """`brace_control.advance_brace_pic` with a reference along y alone.

    Args:
        readings: Leg lengths (6), m, force (3), N, marker (3), m.
        desired: y_d, y_d', y_d'' (3,).
        controller: From `make_controller`.
        commands: Leg forces (6,), N; output.

    Returns:
        False where no pose was found or the legs are singular.
    """
    X_d, rows, geometry, rings, filtered, X_v, impedance, places = controller
    for row in range(3):
        X_d[row, 1] = desired[row]
    result = brace_control.advance_brace_pic(
        readings[0:6], readings[6:9], X_d, rows, geometry, rings, filtered,
        X_v, impedance, places, commands,
    )  # fmt: skip
    return result == brace_control.GOOD
